// Runs a scene's procedure on the mechanical system: all at once, or step by step.
#pragma once
#include "vci/procedure/snapshot.hpp"

#include <functional>
#include <memory>

namespace vci {

struct StageReport {
  std::string step, stage;
  double seconds;
  RelaxResult result;
};

struct DeploymentResult {
  std::vector<StageReport> stages;
  std::vector<StentHistory> stents;
  std::vector<DeviceShape> devices; ///< balloons inflated, in the order of their steps, then stents
  std::vector<std::string> switched_off, warnings;
  Vectors points;                    ///< lumen points at the end, mm
  std::vector<double> wall_stretch;  ///< per lumen point: largest principal stretch
  std::vector<double> malapposition; ///< per lumen point: gap between wall and stent, mm; 0 where no stent faces it
  Balance forces;                    ///< per lumen point at the end, N; 0 where the wall is fixed
  std::map<std::string, Path> paths; ///< axes at the end
  int vertices = 0;                  ///< that took part in the wall
};

/// Who is told what happens. Each may be left out.
struct Observer {
  /// Sees the state at the end of each stage and, where every_steps > 0, every so many steps.
  std::function<void(const Snapshot&)> see;
  int every_steps = 0;
  /// Takes lines of progress and warnings, without their ends.
  std::function<void(const std::string&)> log;
};

/// A procedure under way. It runs one step at a time, and can be asked for its state in between.
class Deployment {
public:
  /// @param lumen, paths as they are before; distances in mm
  Deployment(Scene scene, Lumen lumen, std::map<std::string, Path> paths, Observer observer = {});
  ~Deployment();
  Deployment(Deployment&&) noexcept;
  Deployment& operator=(Deployment&&) noexcept;

  /// Steps of the scene's procedure, and how many of them are done.
  std::size_t steps() const;
  std::size_t steps_done() const;
  /// Runs the next step: its devices are placed, inflated and, but for stents, taken out again.
  /// Throws common::ComputationError naming step, stage, residual and remedy where a stage does not reach force
  /// balance, std::logic_error where no step is left, or an earlier one failed.
  void step();
  /// Lumen points as they are now, mm, in the order of the lumen's.
  Vectors lumen() const;
  /// Lumen and devices as they are now, with their forces.
  Snapshot snapshot() const;
  const std::vector<StageReport>& stages() const;
  /// The result of the steps done. Throws common::ComputationError where a stent touches nothing.
  DeploymentResult result();

private:
  class Run;
  std::unique_ptr<Run> run_;
};

/// Runs all steps of the scene. Throws as Deployment does.
DeploymentResult deploy(const Scene& scene, const Lumen& lumen, const std::map<std::string, Path>& paths,
                        const Observer& observer = {});

} // namespace vci
