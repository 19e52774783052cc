// Measures how long each step of the program takes.
#pragma once
#include <chrono>
#include <string>
#include <vector>

namespace anatomy {

/// Measures the seconds of each named step. The times of a step that runs several times are added.
class StepTimer {
public:
  /// Ends the running step, if any, and starts the next one. Prints the step's name to standard error.
  void start(const std::string& step);
  void stop();
  /// Name and seconds of each step, in the order in which they first ended.
  const std::vector<std::pair<std::string, double>>& seconds() const { return seconds_; }

private:
  std::string running_;
  std::chrono::steady_clock::time_point since_;
  std::vector<std::pair<std::string, double>> seconds_;
};

} // namespace anatomy
