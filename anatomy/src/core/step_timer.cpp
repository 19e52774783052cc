#include "core/step_timer.hpp"
#include <algorithm>
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
  const auto same = std::find_if(seconds_.begin(), seconds_.end(), [&](const auto& s) { return s.first == running_; });
  if (same == seconds_.end())
    seconds_.emplace_back(running_, elapsed.count());
  else
    same->second += elapsed.count();
  running_.clear();
}

} // namespace anatomy
