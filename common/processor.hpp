// Makes results have the same last digits on every processor.
#pragma once
#include <cstdlib>
#include <string>
#include <unistd.h>

namespace common {

/// Starts the program again with the C library's functions (sin, exp, ...) for processors without fused multiply-add.
/// glibc chooses these functions by the processor, so last digits differ, and a hard deployment may end differently.
/// If the user has set hwcaps, or the program cannot be started again, nothing changes.
inline void restart_without_fma(char** argv) {
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
