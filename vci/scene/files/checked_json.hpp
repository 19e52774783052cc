// A JSON object whose keys are read one by one. Missing, unknown and out-of-range keys become an InputError.
#pragma once
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace vci {

class CheckedObject {
public:
  /// @param where place of the object in its file, for messages
  CheckedObject(const nlohmann::json& object, std::string where);
  /// A number within [low, high]. Without a fallback the key is required. The value is also recorded in `values_read`.
  double number(const std::string& key, double low, double high, std::optional<double> fallback = std::nullopt);
  int integer(const std::string& key, int low, int high, std::optional<int> fallback = std::nullopt);
  /// A number as number() reads it, or infinity: null in the file stands for infinity.
  double number_or_infinity(const std::string& key, double low, double high, double fallback);
  std::string text(const std::string& key, std::optional<std::string> fallback = std::nullopt);
  /// Reads one of several names and returns its value. `choices` gives each name with its value in C++.
  template <class Value>
  Value choice(const std::string& key, const std::vector<std::pair<std::string, Value>>& choices, Value fallback) {
    std::vector<std::string> names;
    std::size_t default_index = 0;
    for (const auto& [name, value] : choices) {
      default_index = value == fallback ? names.size() : default_index;
      names.push_back(name);
    }
    return choices[choice_index(key, names, default_index)].second;
  }
  std::vector<double> numbers(const std::string& key);
  bool has(const std::string& key) const { return object_.contains(key); }
  /// The value of a key; an empty object if an optional key is missing.
  nlohmann::json child(const std::string& key, bool required);
  /// A list with at least one entry.
  nlohmann::json list(const std::string& key);
  /// Marks a key that is read elsewhere as known.
  void ignore(const std::string& key) { known_keys_.insert(key); }
  /// Refuses keys that were not read.
  void refuse_unknown_keys() const;
  std::string path(const std::string& key) const { return where_ + "." + key; }
  /// The values read so far, with fallbacks for missing keys.
  nlohmann::json values_read = nlohmann::json::object();
  /// Type, limits and default of each key read so far, in the form of a JSON schema.
  nlohmann::json key_schemas = nlohmann::json::object();

private:
  std::size_t choice_index(const std::string& key, const std::vector<std::string>& names, std::size_t default_index);
  const nlohmann::json* find(const std::string& key, bool required);
  [[noreturn]] void refuse(const std::string& what, const std::string& key, const std::string& remedy) const;
  nlohmann::json object_;
  std::string where_;
  std::set<std::string> known_keys_;
};

} // namespace vci
