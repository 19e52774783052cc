#include "vci/reading.hpp"

#include <csignal>
#include <unistd.h>

namespace vci {

namespace {

std::string message; // made before it may be needed: a signal's handler can hardly do more than write it

extern "C" void refuse_damaged(int) {
  const auto written = ::write(STDERR_FILENO, message.data(), message.size());
  ::_exit(written < 0 ? 1 : 2);
}

} // namespace

DivisionGuard::DivisionGuard(const std::filesystem::path& file) {
  message = std::string(common::InputError("the file cannot be used", file.string(), "a block of data of no size",
                                           "it is damaged: write it anew")
                            .what()) +
            "\n";
  previous_ = std::signal(SIGFPE, refuse_damaged);
}

DivisionGuard::~DivisionGuard() {
  std::signal(SIGFPE, previous_);
}

} // namespace vci
