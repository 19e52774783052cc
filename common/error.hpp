// Errors that a user sees: one message that says what is wrong, where, the value, and the remedy.
#pragma once
#include <exception>
#include <iostream>
#include <stdexcept>
#include <string>

namespace common {

/// Bad input: the program ends with exit code 2.
class InputError : public std::runtime_error {
public:
  InputError(const std::string& what, const std::string& where, const std::string& value, const std::string& remedy)
      : std::runtime_error("error: " + what + "\n  where:  " + where + "\n  value:  " + value +
                           "\n  remedy: " + remedy) {}
};

/// A computation that did not converge or whose result is not to be trusted: exit code 3.
class ComputationError : public std::runtime_error {
public:
  ComputationError(const std::string& what, const std::string& where, const std::string& value,
                   const std::string& remedy)
      : std::runtime_error("error: " + what + "\n  where:  " + where + "\n  value:  " + value +
                           "\n  remedy: " + remedy) {}
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
  } catch (const std::exception& e) {
    std::cerr << "error: " << e.what()
              << "\n  remedy: this is a defect of the program; please report it with its input\n";
    return 1;
  }
}

} // namespace common
