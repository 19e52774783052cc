// The same last digits on every processor.
#pragma once
#include <cstdlib>
#include <string>
#include <unistd.h>

namespace common {

/// Starts the program again with the C library's functions (sin, exp, ...) of processors without fused multiply-add.
/// glibc chooses by the processor, and the last digits differ; a hard deployment can hang on them. Where the user has
/// set hwcaps, or the program cannot be started again, all stays as it is.
inline void same_digits_on_every_processor(char** argv) {
  const char* given = std::getenv("GLIBC_TUNABLES");
  std::string tunables = given ? given : "";
  if (tunables.find("glibc.cpu.hwcaps") != std::string::npos)
    return;
  if (!tunables.empty())
    tunables += ':';
  setenv("GLIBC_TUNABLES", (tunables + "glibc.cpu.hwcaps=-FMA,-FMA4").c_str(), 1);
  execv("/proc/self/exe", argv);
}

} // namespace common
