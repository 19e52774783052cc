// Runs a fuzz target over the files named on the command line: the main function of a build without libFuzzer.
#include "tests/fuzz/target.hpp"

#include <chrono>
#include <exception>
#include <fstream>
#include <iostream>
#include <iterator>
#include <vector>
#if defined(__SANITIZE_ADDRESS__)
#include <sanitizer/common_interface_defs.h>
#endif

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size);

namespace {

constexpr double longest = 5; // s: a reader that takes more over a file of some kB hangs

std::string current; // the file that is being read

#if defined(__SANITIZE_ADDRESS__)
void name_current() {
  std::cerr << "while reading " << current << std::endl;
}
#endif

bool runs(const std::string& file) {
  current = file;
  std::ifstream stream(file, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  if (!stream) {
    std::cerr << file << ": cannot be read\n";
    return false;
  }
  const auto start = std::chrono::steady_clock::now();
  try {
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  } catch (const std::exception& e) {
    std::cerr << file << ": escaped: " << e.what() << '\n';
    return false;
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (seconds > longest)
    std::cerr << file << ": took " << seconds << " s\n";
  return seconds <= longest;
}

} // namespace

int main(int argc, char** argv) {
#if defined(__SANITIZE_ADDRESS__)
  __sanitizer_set_death_callback(name_current);
#endif
  int failed = 0;
  for (const std::string& file : std::vector<std::string>(argv + 1, argv + argc))
    failed += !runs(file);
  std::cout << argc - 1 << " files, " << vci::tests::files_read << " read, " << failed << " failed\n";
  return failed > 0 || argc < 2 ? 1 : 0;
}
