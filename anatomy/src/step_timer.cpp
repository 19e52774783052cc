#include "types.hpp"
#include <iostream>

namespace anatomy {

void StepTimer::start(const std::string& step) {
  stop();
  running_ = step;
  since_ = std::chrono::steady_clock::now();
  std::cerr << "lumen: " << step << '\n';
}

void StepTimer::stop() {
  if (running_.empty())
    return;
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - since_;
  seconds_.emplace_back(running_, elapsed.count());
  running_.clear();
}

} // namespace anatomy
