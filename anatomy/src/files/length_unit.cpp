#include "files/length_unit.hpp"
#include "common/error.hpp"

namespace anatomy {

const char* text_of(LengthUnit unit) {
  switch (unit) {
  case LengthUnit::mm:
    return "mm";
  case LengthUnit::cm:
    return "cm";
  case LengthUnit::m:
    break;
  }
  return "m";
}

LengthUnit length_unit_of(const std::string& text) {
  for (const LengthUnit unit : {LengthUnit::mm, LengthUnit::cm, LengthUnit::m})
    if (text == text_of(unit))
      return unit;
  throw common::InputError("unknown length unit", "units", text, "declare mm, cm or m (--units, units in a case file)");
}

double millimetres_per(LengthUnit unit) {
  switch (unit) {
  case LengthUnit::mm:
    return 1;
  case LengthUnit::cm:
    return 10;
  case LengthUnit::m:
    break;
  }
  return 1000;
}

} // namespace anatomy
