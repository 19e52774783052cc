#include "vci/solver/step_relaxation.hpp"

#include <algorithm>

namespace vci {

namespace {

constexpr double outlier = 2;         // times the typical displacement: a larger one is halved at the first turn
constexpr double turned = -0.3;       // a vertex turns back if the cosine between two of its steps is below this
constexpr int to_and_fro = 4;         // number of turns in a row after which any vertex's displacement is halved
constexpr double least_share = 0.125; // of a displacement that is always taken, so that a vertex can reach its place

} // namespace

void StepRelaxation::damp(Vectors& displacement, const Vectors& last, double typical) {
  if (last.size() != displacement.size())
    return;
  share_.resize(displacement.size(), 1.0);
  turns_.resize(displacement.size(), 0);
  for (std::size_t i = 0; i < displacement.size(); ++i) {
    const double now = displacement[i].norm(), along = displacement[i].dot(last[i]);
    const bool turns_back = along < 0 && along < turned * now * last[i].norm();
    turns_[i] = turns_back ? turns_[i] + 1 : 0;
    const bool hangs = turns_back && (now > outlier * typical || turns_[i] >= to_and_fro);
    share_[i] = hangs ? std::max(least_share, 0.5 * share_[i]) : std::min(1.0, 2 * share_[i]);
    displacement[i] *= share_[i];
  }
}

} // namespace vci
