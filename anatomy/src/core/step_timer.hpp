// Seconds per named step of the program.
#pragma once
#include <chrono>
#include <string>
#include <vector>

namespace anatomy {

/// Seconds per named step, in the order in which they ran.
class StepTimer {
public:
  /// Ends the running step and starts the next one, with a line on standard error.
  void start(const std::string& step);
  void stop();
  const std::vector<std::pair<std::string, double>>& seconds() const { return seconds_; }

private:
  std::string running_;
  std::chrono::steady_clock::time_point since_;
  std::vector<std::pair<std::string, double>> seconds_;
};

} // namespace anatomy
