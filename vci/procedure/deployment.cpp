#include "vci/procedure/deployment.hpp"
#include "common/error.hpp"
#include "vci/contact/apposition.hpp"
#include "vci/devices/balloon/balloon.hpp"
#include "vci/procedure/notices.hpp"
#include "vci/procedure/placement.hpp"
#include "vci/procedure/region.hpp"
#include "vci/procedure/standing.hpp"
#include "vci/procedure/unfolding.hpp"
#include "vci/solver/refusal.hpp"
#include "vci/solver/textbook.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>

namespace vci {

namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// The state of a procedure under way.
class Run {
public:
  Run(const Scene& scene, const Lumen& lumen, const std::map<std::string, Path>& paths, const Observer* observer)
      : scene_(scene), lumen_(lumen), reference_paths_(paths), observer_(observer) {
    const bool whole = scene.numerics.integrator.textbook;
    const std::vector<char> free =
        whole ? std::vector<char>(lumen.points.size(), 1) : region_of_interest(lumen, scene, paths);
    wall_ = add_wall(system_, lumen, free, scene.wall, scene.map_pa);
    result_.vertices = static_cast<int>(wall_.vertex.size());
    result_.switched_off = left_out(scene, lumen.points.size() - wall_.vertex.size(), lumen.points.size());
    for (const std::string& line : result_.switched_off)
      std::cerr << "switched off: " << line << '\n';
    for (const std::string& warning : warnings_of_plan(scene))
      warn(warning);
    if (observer_ && observer_->every_steps > 0)
      interactions_.after_step = [this](int steps, const Balance& forces) {
        if (steps % observer_->every_steps == 0)
          show(steps, forces);
      };
  }

  void step(const Step& step) {
    place_devices(step);
    for (const Stage& stage : stages_of(step, scene_.numerics))
      relax_stage(step, stage);
  }

  Deployment finish() {
    result_.points = moved_points(lumen_, wall_, system_);
    for (const auto& [name, path] : reference_paths_)
      result_.paths[name] = follow_wall(path, lumen_, result_.points);
    // only now: a stent that hangs free on the way may yet be dilated
    check_borne(system_, interactions_, result_.stents, result_.points, lumen_.triangles, result_.paths);
    result_.wall_stretch.assign(lumen_.points.size(), 1.0);
    const std::vector<double> stretch = vertex_stretch(*wall_.intima, system_.body(0).triangles, system_.x);
    for (std::size_t i = 0; i < wall_.vertex.size(); ++i)
      result_.wall_stretch[wall_.vertex[i]] = stretch[i];
    read_malapposition();
    result_.forces = on_lumen(balance_);
    for (StentHistory& h : result_.stents)
      shapes_.push_back(shape_of(h.stent.body, h.device, balance_));
    return std::move(result_);
  }
  std::vector<DeviceShape> take_shapes() { return std::move(shapes_); }

private:
  Vectors on_lumen(const Vectors& force) const {
    Vectors all(force.empty() ? 0 : lumen_.points.size(), Vec3::Zero());
    for (std::size_t i = 0; i < wall_.vertex.size() && !all.empty(); ++i)
      all[wall_.vertex[i]] = force[i];
    return all;
  }
  Balance on_lumen(const Balance& b) const {
    return {on_lumen(b.pressure), on_lumen(b.contact), on_lumen(b.foundation), on_lumen(b.residual)};
  }

  Vectors part(const Vectors& all, int body) const {
    const auto first = all.begin() + system_.body(body).first;
    return all.empty() ? Vectors{} : Vectors(first, first + system_.body(body).count);
  }

  DeviceShape shape_of(int body, const std::string& name, const Balance& b) const {
    DeviceShape shape{
        is_stent(body) ? DeviceShape::Kind::stent : DeviceShape::Kind::balloon,
        name,
        part(system_.x, body),
        system_.body(body).triangles,
        {part(b.pressure, body), part(b.contact, body), part(b.foundation, body), part(b.residual, body)}};
    for (Triangle& t : shape.triangles)
      for (int& v : t)
        v -= system_.body(body).first;
    return shape;
  }

  void warn(const std::string& text) {
    result_.warnings.push_back(text);
    std::cerr << "warning: " << text << '\n';
  }

  Vectors lumen_now() const { return moved_points(lumen_, wall_, system_); }

  void show(int steps, const Balance& forces) const {
    Snapshot snapshot{static_cast<int>(result_.stages.size()), steps, lumen_now(), on_lumen(forces), {}};
    for (int b = 1; b < system_.bodies(); ++b)
      snapshot.devices.push_back(shape_of(b, system_.body(b).name, forces));
    observer_->see(snapshot);
  }

  /// A device's rings where a placement wants them, on the axis as it is now.
  Course course_of(const Placement& p, RingGrid grid, const BalloonSpec& balloon, const Vectors& moved) const {
    const Path path = follow_wall(reference_paths_.at(p.branch), lumen_, moved);
    std::vector<Frame> frames = path.frames(grid.along(p.centre_s));
    const BalloonChart chart(balloon.chart_pressure_bar, balloon.chart_diameter, balloon.crimped_diameter);
    return {std::move(grid), std::move(frames), 0.5 * chart.diameter_at(p.pressure_bar)};
  }

  /// How a device lies to each body present: inside the wall and the stents, leaving stents where its course does.
  std::vector<ContactSides> sides_of(const Course& course) const {
    std::vector<ContactSides> sides(system_.bodies());
    for (const StentHistory& h : result_.stents)
      sides[h.stent.body] = leaving_through(system_, h.stent, course);
    return sides;
  }

  void add_contacts(int inner, std::vector<ContactSides> sides) {
    for (std::size_t body = 0; body < sides.size(); ++body)
      interactions_.contacts.emplace_back(inner, static_cast<int>(body), scene_.numerics.contact,
                                          std::move(sides[body]), interactions_.trees);
  }

  /// Returns the radius (mm) of the stent's thinnest ring.
  double place_stent(const Placement& p, const BalloonSpec& balloon, const Vectors& moved) {
    const StentSpec& spec = scene_.stents.at(p.device);
    const Course course = course_of(p, stent_grid(spec, scene_.numerics.device_edge), balloon, moved);
    std::vector<ContactSides> sides = sides_of(course);
    const std::vector<double> radii = start_radii(system_, course, spec.crimped_diameter, sides);
    Stent stent = add_stent(system_, spec, p.device, course.grid, course.frames, radii);
    add_contacts(stent.body, std::move(sides));
    result_.stents.push_back({p.device, p.branch, p.centre_s, std::move(stent)});
    return *std::min_element(radii.begin(), radii.end());
  }

  const BalloonSpec& balloon_of(const Placement& p) const {
    const bool is_stent = scene_.stents.contains(p.device);
    return scene_.balloons.at(is_stent ? scene_.stents.at(p.device).balloon : p.device);
  }

  void place_devices(const Step& step) {
    const Vectors moved = lumen_now();
    balloons_.clear();
    std::vector<Course> courses;
    for (const Placement& p : step.devices)
      courses.push_back(course_of(p, balloon_grid(balloon_of(p), scene_.numerics.device_edge), balloon_of(p), moved));
    if (step.devices.size() == 2)
      set_side_by_side(
          courses[0], courses[1],
          std::max(balloon_of(step.devices[0]).crimped_diameter, balloon_of(step.devices[1]).crimped_diameter));
    // stents first: balloons are taken out at the end of the step and must be the last bodies
    std::vector<std::vector<ContactSides>> sides;
    std::vector<std::vector<double>> radii;
    for (std::size_t k = 0; k < courses.size(); ++k) {
      const Placement& p = step.devices[k];
      sides.push_back(sides_of(courses[k]));
      radii.push_back(start_radii(system_, courses[k], balloon_of(p).crimped_diameter, sides[k]));
      if (!scene_.stents.contains(p.device))
        continue;
      const double thinnest = place_stent(p, balloon_of(p), moved);
      sides[k].emplace_back(); // the balloon lies inside the stent, clear of it
      for (double& r : radii[k])
        r = std::max(0.04, std::min(r, 0.9 * thinnest - start_clearance));
    }
    for (std::size_t k = 0; k < courses.size(); ++k) {
      balloons_.push_back(
          add_balloon(system_, balloon_of(step.devices[k]), courses[k].grid, courses[k].frames, radii[k]));
      add_contacts(balloons_.back().body, std::move(sides[k]));
      add_layers(interactions_, system_, balloons_.back(), balloon_of(step.devices[k]), scene_.numerics.contact);
      for (std::size_t other = 0; other < k; ++other)
        interactions_.contacts.emplace_back(balloons_[k].body, balloons_[other].body, scene_.numerics.contact,
                                            ContactSides{false, {}, {}}, interactions_.trees);
    }
  }

  void remove_balloons() {
    while (!balloons_.empty()) {
      interactions_.forget(balloons_.back().body);
      system_.remove_last_body();
      balloons_.pop_back();
    }
  }

  void relax_stage(const Step& step, const Stage& stage) {
    const auto start = std::chrono::steady_clock::now();
    if (!stage.with_balloons)
      remove_balloons();
    for (std::size_t k = 0; k < balloons_.size(); ++k)
      set_pressure(balloons_[k], stage.pressure_fraction * step.devices[k].pressure_bar * mpa_per_bar);
    // during an inflation stents slide and open along the wall; ties are made anew at its end
    if (stage.with_balloons)
      interactions_.ties.clear();
    IntegratorSettings settings = scene_.numerics.integrator;
    for (std::size_t k = 0; k < balloons_.size(); ++k)
      settings = with_folds(settings, balloon_of(step.devices[k]), stage.pressure_fraction < 1);
    const RelaxResult r = (settings.textbook ? relax_textbook : relax)(system_, interactions_, settings, &balance_);
    result_.stages.push_back({step.name, stage.name, seconds_since(start), r});
    std::cerr << step.name << " / " << stage.name << ": " << r.steps << " steps, " << r.cg_iterations
              << " cg iterations, residual " << r.residual << ", " << r.contacts << " contacts, penetration "
              << r.mean_penetration << " mean " << r.maximal_penetration << " max mm" << deepest_place(r, system_)
              << (r.careful_from < 0 ? "" : ", with care from step " + std::to_string(r.careful_from)) << ", "
              << result_.stages.back().seconds << " s\n";
    if (!r.converged)
      refuse(step, stage, r);
    if (!settings.textbook) // whose states are reported as they are
      check_inside(system_, *interactions_.trees, step.name + " / " + stage.name);
    after_balance(stage, step);
    if (observer_)
      show(r.steps, balance_);
  }

  [[noreturn]] void refuse(const Step& step, const Stage& stage, const RelaxResult& r) const {
    const std::string where = step.name + " / " + stage.name;
    if (!stage.with_balloons && r.contacts == 0 && !result_.stents.empty() && interactions_.ties.empty())
      throw common::ComputationError("a stent touches nothing once its balloon is out", where, "0 contacts",
                                     "choose a larger stent or raise its pressure_bar: it is smaller than the lumen");
    throw no_balance(where, r, scene_.numerics.integrator, system_);
  }

  void after_balance(const Stage& stage, const Step& step) {
    if (stage.ties_stents)
      tie_stents();
    for (StentHistory& h : result_.stents)
      if (!stage.with_balloons)
        note_extraction(h, system_);
      else if (stage.pressure_fraction == 1.0) {
        note_inflation(h, system_, contacts_onto(h.stent.body, false));
        if (const auto warning = overexpansion(system_, h, scene_.stents.at(h.device), step.name))
          warn(*warning);
      }
    if (stage.pressure_fraction == 1.0)
      for (std::size_t k = 0; k < balloons_.size(); ++k)
        shapes_.push_back(shape_of(
            balloons_[k].body, step.name + "_balloon" + (balloons_.size() > 1 ? std::to_string(k + 1) : ""), balance_));
  }

  std::vector<ContactPoint> contacts_onto(int outer, bool of_stents) {
    const Normals normals(area_vectors(system_));
    std::vector<ContactPoint> points;
    for (SurfaceContact& contact : interactions_.contacts)
      if (contact.outer() == outer && is_stent(contact.inner()) == of_stents)
        contact.detect(system_, normals, points);
    return points;
  }

  void tie_stents() {
    if (scene_.numerics.tie_stiffness > 0) // without, contact alone holds them
      for (const ContactPoint& p : contacts_onto(0, true))
        interactions_.ties.push_back(tie_of(p, system_.x, scene_.numerics.tie_stiffness));
  }

  bool is_stent(int body) const { return system_.body(body).name == "stent"; }

  void read_malapposition() {
    const std::vector<double> gaps = malapposition(system_, "stent");
    result_.malapposition.assign(lumen_.points.size(), 0.0);
    for (std::size_t i = 0; i < gaps.size(); ++i)
      result_.malapposition[wall_.vertex[i]] = gaps[i];
  }

  const Scene& scene_;
  const Lumen& lumen_;
  const std::map<std::string, Path>& reference_paths_;
  const Observer* observer_;
  System system_;
  Wall wall_;
  Interactions interactions_;
  Balance balance_; ///< of the last stage
  std::vector<Balloon> balloons_;
  std::vector<DeviceShape> shapes_;
  Deployment result_;
};

} // namespace

Deployment deploy(const Scene& scene, const Lumen& lumen, const std::map<std::string, Path>& paths,
                  const Observer* observer) {
  Run run(scene, lumen, paths, observer);
  for (const Step& step : scene.procedure)
    run.step(step);
  Deployment result = run.finish();
  result.balloons = run.take_shapes();
  return result;
}

} // namespace vci
