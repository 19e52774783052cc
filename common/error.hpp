// Errors that a user sees. Their one message says what is wrong, where, the value, and the remedy.
#pragma once
#include <algorithm>
#include <exception>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string>

namespace common {

/// Joins the parts of a message into one text. Each part is written as operator<< writes it.
template <class... Parts> std::string text(const Parts&... parts) {
  std::ostringstream stream;
  (stream << ... << parts);
  return stream.str();
}

/// Text of an error for the user. A zero byte from a damaged file becomes a question mark, since it would end the text.
inline std::string error_message(const std::string& what, const std::string& where, const std::string& value,
                                 const std::string& remedy) {
  std::string text = "error: " + what + "\n  where:  " + where + "\n  value:  " + value + "\n  remedy: " + remedy;
  std::replace(text.begin(), text.end(), '\0', '?');
  return text;
}

/// Bad input: the program ends with exit code 2.
class InputError : public std::runtime_error {
public:
  InputError(const std::string& what, const std::string& where, const std::string& value, const std::string& remedy)
      : std::runtime_error(error_message(what, where, value, remedy)) {}
};

/// A computation did not converge, or its result cannot be trusted: the program ends with exit code 3.
class ComputationError : public std::runtime_error {
public:
  ComputationError(const std::string& what, const std::string& where, const std::string& value,
                   const std::string& remedy)
      : std::runtime_error(error_message(what, where, value, remedy)) {}
};

/// A file cannot be written, for example on a full disk: the program ends with exit code 1.
class WriteError : public std::runtime_error {
public:
  /// @param reason what the system says; may be empty
  explicit WriteError(const std::string& file, const std::string& reason = "")
      : std::runtime_error(error_message("the file cannot be written", file, reason,
                                         "check the folder, its rights and the free space")) {}
};

/// Runs a command and turns exceptions into one message and the exit code of docs/design.md.
template <class Command> int guarded(Command&& command) {
  try {
    return command();
  } catch (const InputError& e) {
    std::cerr << e.what() << '\n';
    return 2;
  } catch (const ComputationError& e) {
    std::cerr << e.what() << '\n';
    return 3;
  } catch (const WriteError& e) {
    std::cerr << e.what() << '\n';
    return 1;
  } catch (const std::exception& e) {
    std::cerr << "error: " << e.what()
              << "\n  remedy: this is a defect of the program; please report it with its input\n";
    return 1;
  }
}

} // namespace common
