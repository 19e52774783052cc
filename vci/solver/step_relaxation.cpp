#include "vci/solver/step_relaxation.hpp"

#include <algorithm>

namespace vci {

namespace {

constexpr double outlier_factor = 2; // displacements above this times large_displacement are halved at the first turn
constexpr double turn_cosine = -0.3; // a vertex turns back if the cosine between two of its steps is below this
constexpr int oscillation_turns = 4; // number of turns in a row after which any vertex's displacement is halved
// A turn counts only if its displacement is longer than this share of the one before: decaying turns end by themselves.
constexpr double least_decay = 0.8;
// share of a displacement that is always taken, so that a vertex can reach its place
constexpr double least_step_share = 0.125;

} // namespace

void StepRelaxation::damp(Vectors& displacement, const Vectors& previous, double large_displacement) {
  if (previous.size() != displacement.size())
    return;
  share_.resize(displacement.size(), 1.0);
  turns_.resize(displacement.size(), 0);
  for (std::size_t i = 0; i < displacement.size(); ++i) {
    const double length = displacement[i].norm(), along = displacement[i].dot(previous[i]);
    const bool turns_back = along < 0 && along < turn_cosine * length * previous[i].norm();
    turns_[i] = turns_back && length > least_decay * previous[i].norm() ? turns_[i] + 1 : 0;
    const bool oscillates =
        turns_back && (length > outlier_factor * large_displacement || turns_[i] >= oscillation_turns);
    share_[i] = oscillates ? std::max(least_step_share, 0.5 * share_[i]) : std::min(1.0, 2 * share_[i]);
    displacement[i] *= share_[i];
  }
}

} // namespace vci
