// The length units that a surface file may have.
#pragma once
#include <string>

namespace anatomy {

enum class LengthUnit { mm, cm, m };

/// The unit as the user and the files write it, and the unit of such a text. The second function throws InputError for
/// a text that is not mm, cm or m.
const char* text_of(LengthUnit unit);
LengthUnit length_unit_of(const std::string& text);

/// Millimetres per unit.
double millimetres_per(LengthUnit unit);

} // namespace anatomy
