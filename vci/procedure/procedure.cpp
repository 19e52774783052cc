#include "vci/procedure/procedure.hpp"

#include <algorithm>

namespace vci {

namespace {

// Least share of the inflation pressure in the first stage of a stent's step. A crimped stent opens only beyond its
// yield pressure (some 3 bar, plus what unfolds the balloon). With a lower pressure it would not reach the wall.
constexpr double stent_opening_fraction = 0.75;

} // namespace

std::vector<Stage> stages_of(const Step& step, const Numerics& numerics) {
  const bool opens_stent = step.action == Action::stent;
  const double to_contact = opens_stent ? std::max(numerics.contact_pressure_fraction, stent_opening_fraction)
                                        : numerics.contact_pressure_fraction;
  return {{"deployment-to-contact", to_contact, true, false},
          {"contact-to-balance", 1.0, true, true},
          {"balloon-extraction", 0.0, false, false}};
}

} // namespace vci
