#include "vci/procedure/deployment.hpp"
#include "common/error.hpp"
#include "vci/contact/apposition.hpp"
#include "vci/procedure/device_setup.hpp"
#include "vci/procedure/diagnostics.hpp"
#include "vci/procedure/procedure.hpp"
#include "vci/procedure/region.hpp"
#include "vci/procedure/state_checks.hpp"
#include "vci/procedure/unfolding.hpp"
#include "vci/solver/convergence_error.hpp"
#include "vci/solver/textbook.hpp"

#include <chrono>
#include <sstream>
#include <stdexcept>

namespace vci {

namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::string progress_line(const StageReport& stage, const System& system) {
  const RelaxResult& r = stage.result;
  std::ostringstream line;
  line << stage.step << " / " << stage.stage << ": " << r.steps << " steps, " << r.cg_iterations
       << " cg iterations, residual " << r.residual << ", " << r.contacts << " contacts, penetration "
       << r.mean_penetration << " mean " << r.maximal_penetration << " max mm" << describe_deepest(r, system)
       << (r.careful_from < 0 ? "" : ", with care from step " + std::to_string(r.careful_from)) << ", " << stage.seconds
       << " s";
  return line.str();
}

[[noreturn]] void throw_failed_stage(const RunState& run, const std::string& where, const Stage& stage,
                                     const RelaxResult& r) {
  if (!stage.with_balloons && r.contacts == 0 && !run.stents.empty() && run.interactions.ties.empty())
    throw common::ComputationError("a stent touches nothing once its balloon is out", where, "0 contacts",
                                   "choose a larger stent or raise its pressure_bar: it is smaller than the lumen");
  throw convergence_error(where, r, run.scene.numerics.integrator, run.system);
}

/// Sets pressures, balloons and ties before a stage is relaxed. Returns the solver's settings for this stage.
IntegratorSettings prepare_stage(RunState& run, const Step& step, const Stage& stage) {
  if (!stage.with_balloons)
    remove_balloons(run);
  for (std::size_t k = 0; k < run.balloons.size(); ++k)
    set_pressure(run.balloons[k], stage.pressure_fraction * step.devices[k].pressure_bar * mpa_per_bar);
  // During an inflation stents slide along the wall as they open. New ties are made at its end.
  if (stage.with_balloons)
    run.interactions.ties.clear();
  IntegratorSettings settings = run.scene.numerics.integrator;
  for (std::size_t k = 0; k < run.balloons.size(); ++k)
    settings =
        folded_balloon_settings(settings, run.scene.balloon(step.devices[k].device), stage.pressure_fraction < 1);
  return settings;
}

std::vector<double> malapposition_on_lumen(const RunState& run) {
  Vectors wall; // before the procedure, as the axes are
  for (const int v : run.wall.lumen_vertex)
    wall.push_back(run.lumen.points[v]);
  std::vector<StentAtWall> stents;
  for (const StentHistory& h : run.stents) {
    const double half = 0.5 * run.scene.opened_length(h.device);
    stents.push_back({h.stent.body, points_beside(wall, run.paths, h.branch, h.centre_s - half, h.centre_s + half)});
  }
  const std::vector<double> gaps = malapposition(run.system, stents);
  std::vector<double> all(run.lumen.points.size(), 0.0);
  for (std::size_t i = 0; i < gaps.size(); ++i)
    all[run.wall.lumen_vertex[i]] = gaps[i];
  return all;
}

std::vector<double> stretch_on_lumen(const RunState& run) {
  std::vector<double> all(run.lumen.points.size(), 1.0);
  const std::vector<double> stretch =
      vertex_stretch(*run.wall.healthy_layer, run.system.body(0).triangles, run.system.x);
  for (std::size_t i = 0; i < run.wall.lumen_vertex.size(); ++i)
    all[run.wall.lumen_vertex[i]] = stretch[i];
  return all;
}

} // namespace

class Deployment::Run {
public:
  Run(Scene scene, Lumen lumen, std::map<std::string, Path> paths, Observer observer)
      : state(std::move(scene), std::move(lumen), std::move(paths)), observer_(std::move(observer)) {
    const std::size_t moving = state.wall.lumen_vertex.size(), all = state.lumen.points.size();
    switched_off_ =
        switched_off_parts(state.scene, all - moving, all, state.paths.size() > 1 && state.lumen.branch.empty());
    for (const std::string& line : switched_off_)
      log("switched off: " + line);
    for (const std::string& warning : warnings_of_plan(state.scene))
      warn(warning);
    if (observer_.see && observer_.every_steps > 0)
      state.interactions.after_step = [this](int steps, const Balance& forces) {
        if (steps % observer_.every_steps == 0)
          observer_.see(snapshot_of(state, static_cast<int>(stages.size()), steps, forces));
      };
  }
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;

  void step() {
    if (failed_ || steps_done == state.scene.procedure.size())
      throw std::logic_error(failed_ ? "a step of this procedure has failed" : "all steps of the procedure are done");
    const Step& step = state.scene.procedure[steps_done];
    failed_ = true; // remains true if an exception ends the step
    place_devices(state, step);
    for (const Stage& stage : stages_of(step, state.scene.numerics))
      relax_stage(step, stage);
    failed_ = false;
    ++steps_done;
  }

  DeploymentResult result() {
    DeploymentResult r;
    r.points = state.current_lumen();
    for (const auto& [name, path] : state.paths)
      r.paths[name] = follow_wall(path, state.lumen, r.points);
    // Checked only at the end, because a later step may still dilate a stent that touches nothing.
    check_stents_supported(state.system, state.interactions, state.stents, r.points, state.lumen.triangles, r.paths);
    r.stages = stages;
    r.stents = state.stents;
    r.devices = balloon_shapes_;
    for (const StentHistory& h : state.stents)
      r.devices.push_back(shape_of(state, h.stent.body, h.device, state.balance));
    r.switched_off = switched_off_;
    r.warnings = warnings_;
    r.wall_stretch = stretch_on_lumen(state);
    r.malapposition = malapposition_on_lumen(state);
    r.forces = forces_on_lumen(state, state.balance);
    r.vertices = static_cast<int>(state.wall.lumen_vertex.size());
    return r;
  }

  RunState state;
  std::vector<StageReport> stages;
  std::size_t steps_done = 0;

private:
  void log(const std::string& line) const {
    if (observer_.log)
      observer_.log(line);
  }

  void warn(const std::string& text) {
    warnings_.push_back(text);
    log("warning: " + text);
  }

  void relax_stage(const Step& step, const Stage& stage) {
    const auto start = std::chrono::steady_clock::now();
    const IntegratorSettings settings = prepare_stage(state, step, stage);
    const RelaxResult r =
        (settings.textbook ? relax_textbook : relax)(state.system, state.interactions, settings, &state.balance);
    stages.push_back({step.name, stage.name, seconds_since(start), r});
    log(progress_line(stages.back(), state.system));
    const std::string where = step.name + " / " + stage.name;
    if (!r.converged)
      throw_failed_stage(state, where, stage, r);
    if (!settings.textbook) { // states of the textbook scheme are reported unchecked
      check_devices_inside(state.system, *state.interactions.trees, state.current_lumen(), state.lumen.triangles,
                           where);
      if (const auto warning = penetration_warning(r, state.system, settings.maximal_penetration, where))
        warn(*warning);
    }
    after_balance(stage, step);
    if (observer_.see)
      observer_.see(snapshot_of(state, static_cast<int>(stages.size()), r.steps, state.balance));
  }

  void after_balance(const Stage& stage, const Step& step) {
    if (stage.ties_stents)
      tie_stents(state);
    for (StentHistory& h : state.stents)
      if (!stage.with_balloons)
        record_extraction(h, state.system);
      else if (stage.pressure_fraction == 1.0) {
        record_inflation(h, state.system, contacts_on_body(state, h.stent.body, false));
        if (const auto warning = overexpansion_warning(state.system, h, state.scene.stents.at(h.device), step.name))
          warn(*warning);
      }
    if (stage.pressure_fraction == 1.0)
      store_balloon_shapes(step.name + "_balloon");
  }

  void store_balloon_shapes(const std::string& name) {
    const bool several = state.balloons.size() > 1;
    for (std::size_t k = 0; k < state.balloons.size(); ++k)
      balloon_shapes_.push_back(
          shape_of(state, state.balloons[k].body, name + (several ? std::to_string(k + 1) : ""), state.balance));
  }

  Observer observer_;
  std::vector<std::string> switched_off_, warnings_;
  std::vector<DeviceShape> balloon_shapes_; ///< the inflated balloons of all steps that have run
  bool failed_ = false;
};

Deployment::Deployment(Scene scene, Lumen lumen, std::map<std::string, Path> paths, Observer observer)
    : run_(std::make_unique<Run>(std::move(scene), std::move(lumen), std::move(paths), std::move(observer))) {}
Deployment::~Deployment() = default;
Deployment::Deployment(Deployment&&) noexcept = default;
Deployment& Deployment::operator=(Deployment&&) noexcept = default;

std::size_t Deployment::steps() const {
  return run_->state.scene.procedure.size();
}

std::size_t Deployment::steps_done() const {
  return run_->steps_done;
}

void Deployment::step() {
  run_->step();
}

Vectors Deployment::lumen() const {
  return run_->state.current_lumen();
}

Snapshot Deployment::snapshot() const {
  return snapshot_of(run_->state, static_cast<int>(run_->stages.size()), 0, run_->state.balance);
}

const std::vector<StageReport>& Deployment::stages() const {
  return run_->stages;
}

DeploymentResult Deployment::result() {
  return run_->result();
}

DeploymentResult deploy(const Scene& scene, const Lumen& lumen, const std::map<std::string, Path>& paths,
                        const Observer& observer) {
  Deployment deployment(scene, lumen, paths, observer);
  while (deployment.steps_done() < deployment.steps())
    deployment.step();
  return deployment.result();
}

} // namespace vci
