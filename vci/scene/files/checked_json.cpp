#include "vci/scene/files/checked_json.hpp"
#include "common/error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace vci {

using nlohmann::json;

CheckedObject::CheckedObject(const json& object, std::string where) : object_(object), where_(std::move(where)) {
  if (!object_.is_object())
    throw common::InputError("an object is expected", where_, object_.dump().substr(0, 80),
                             "write {\"key\": value, ...}");
}

void CheckedObject::refuse(const std::string& what, const std::string& key, const std::string& remedy) const {
  const std::string value = object_.contains(key) ? object_.at(key).dump().substr(0, 80) : "missing";
  throw common::InputError(what, path(key), value, remedy);
}

const json* CheckedObject::find(const std::string& key, bool required) {
  known_keys_.insert(key);
  if (!object_.contains(key)) {
    if (required)
      refuse("a required key is missing", key, "add it; docs/design.md describes the file");
    return nullptr;
  }
  return &object_.at(key);
}

double CheckedObject::number(const std::string& key, double low, double high, std::optional<double> fallback) {
  const json* value = find(key, !fallback);
  double result = fallback.value_or(0);
  if (value) {
    std::ostringstream range;
    range << "give a number from " << low << " to " << high;
    if (!value->is_number())
      refuse("a number is expected", key, range.str());
    result = value->get<double>();
    if (!std::isfinite(result) || result < low || result > high)
      refuse("a number is out of its range", key, range.str());
  }
  values_read[key] = result;
  key_schemas[key] = {{"type", "number"}, {"minimum", low}, {"maximum", high}};
  if (fallback)
    key_schemas[key]["default"] = *fallback;
  return result;
}

double CheckedObject::number_or_infinity(const std::string& key, double low, double high, double fallback) {
  constexpr double never = std::numeric_limits<double>::infinity();
  const json* value = find(key, false);
  const bool is_never = value ? value->is_null() : std::isinf(fallback);
  const double result = is_never ? never : number(key, low, high, fallback);
  if (is_never)
    values_read[key] = nullptr;
  key_schemas[key] = {{"type", {"number", "null"}}, {"minimum", low}, {"maximum", high}, {"default", nullptr}};
  if (!std::isinf(fallback))
    key_schemas[key]["default"] = fallback;
  return result;
}

int CheckedObject::integer(const std::string& key, int low, int high, std::optional<int> fallback) {
  const double value = number(key, low, high, fallback ? std::optional<double>(*fallback) : std::nullopt);
  if (value != std::floor(value))
    refuse("a whole number is expected", key, "leave out the decimals");
  values_read[key] = static_cast<int>(value);
  key_schemas[key]["type"] = "integer";
  return static_cast<int>(value);
}

std::string CheckedObject::text(const std::string& key, std::optional<std::string> fallback) {
  const json* value = find(key, !fallback);
  if (value && !value->is_string())
    refuse("a text is expected", key, "write it in double quotes");
  const std::string result = value ? value->get<std::string>() : *fallback;
  values_read[key] = result;
  return result;
}

std::size_t CheckedObject::choice_index(const std::string& key, const std::vector<std::string>& names,
                                        std::size_t default_index) {
  key_schemas[key] = {{"enum", names}, {"default", names[default_index]}};
  const std::string given = text(key, names[default_index]);
  const auto found = std::find(names.begin(), names.end(), given);
  if (found != names.end())
    return static_cast<std::size_t>(found - names.begin());
  std::string all;
  for (const std::string& name : names)
    all += (all.empty() ? "" : name == names.back() ? " or " : ", ") + name;
  throw common::InputError("an unknown choice", path(key), given, "use " + all);
}

std::vector<double> CheckedObject::numbers(const std::string& key) {
  const json* value = find(key, true);
  std::vector<double> result;
  if (!value->is_array())
    refuse("a list of numbers is expected", key, "write [a, b, ...]");
  for (const json& item : *value) {
    if (!item.is_number())
      refuse("a list of numbers is expected", key, "write [a, b, ...]");
    result.push_back(item.get<double>());
  }
  values_read[key] = result;
  return result;
}

json CheckedObject::child(const std::string& key, bool required) {
  const json* value = find(key, required);
  return value ? *value : json::object();
}

json CheckedObject::list(const std::string& key) {
  const json* value = find(key, true);
  if (!value->is_array() || value->empty())
    refuse("a list with one entry or more is expected", key, "write [{...}, ...]");
  return *value;
}

void CheckedObject::refuse_unknown_keys() const {
  for (const auto& [key, value] : object_.items())
    if (!known_keys_.contains(key)) {
      std::string all;
      for (const std::string& k : known_keys_)
        all += (all.empty() ? "" : ", ") + k;
      refuse("an unknown key", key, "remove it; known keys are: " + all);
    }
}

} // namespace vci
