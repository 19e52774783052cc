// Parsing of the command line. A mistake in it is bad input like any other: one message, exit code 2.
#pragma once
#include "common/error.hpp"
#include <CLI/CLI.hpp>
#include <optional>

namespace common {

/// Parses the command line. Returns nothing if a command is to run, else the exit code of the program. The code is 0
/// after --help, and 2 after one message that names the command and the argument that it does not understand.
inline std::optional<int> exit_code_of_parsing(CLI::App& app, int argc, const char* const* argv) {
  try {
    app.parse(argc, argv);
    return std::nullopt;
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0)
      return app.exit(e);
    std::string command = app.get_name();
    for (const CLI::App* chosen : app.get_subcommands())
      command += " " + chosen->get_name();
    std::cerr
        << InputError("the command line is not understood", command, e.what(), "see " + command + " --help").what()
        << '\n';
    return 2;
  }
}

} // namespace common
