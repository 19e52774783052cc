#include "vci/deployment.hpp"
#include "common/error.hpp"
#include "vci/closest_point.hpp"
#include "vci/surface.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>
#include <numeric>
#include <sstream>

namespace vci {

namespace {

constexpr double start_clearance = 0.03; // mm between a device and what surrounds it at the start

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// The state of a procedure under way.
class Run {
public:
  Run(const Scene& scene, const Lumen& lumen, const std::map<std::string, Path>& paths)
      : scene_(scene), lumen_(lumen), reference_paths_(paths) {
    const std::vector<char> free = region_of_interest(lumen, scene, paths);
    wall_ = add_wall(system_, lumen, free, scene.wall, scene.map_pa);
    result_.vertices = static_cast<int>(wall_.vertex.size());
    std::ostringstream region;
    region << "wall further than " << scene.numerics.region_margin
           << " mm from every device: " << lumen.points.size() - wall_.vertex.size() << " of " << lumen.points.size()
           << " vertices stay where they are";
    result_.switched_off = {region.str(), "folding: balloons start as small tubes that unfold softly",
                            "self-contact of the wall and of the devices",
                            "mean blood pressure during occlusion: kept as prestress"};
    for (const std::string& line : result_.switched_off)
      std::cerr << "switched off: " << line << '\n';
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
    result_.wall_stretch.assign(lumen_.points.size(), 1.0);
    const std::vector<double> stretch = wall_.intima->largest_stretch(system_.x);
    const Triangles& triangles = system_.body(0).triangles;
    for (std::size_t k = 0; k < triangles.size(); ++k)
      for (int v : triangles[k]) {
        double& s = result_.wall_stretch[wall_.vertex[v]];
        s = std::max(s, stretch[k]);
      }
    for (StentHistory& h : result_.stents) {
      const Vectors centres = ring_centres(system_, h.stent.body, h.stent.grid);
      h.final_length = 0;
      for (std::size_t k = 1; k < centres.size(); ++k)
        h.final_length += (centres[k] - centres[k - 1]).norm();
    }
    read_malapposition();
    result_.forces = {on_lumen(balance_.pressure), on_lumen(balance_.contact), on_lumen(balance_.foundation),
                      on_lumen(balance_.residual)};
    for (StentHistory& h : result_.stents)
      shapes_.push_back(shape_of(h.stent.body, h.device));
    return std::move(result_);
  }
  std::vector<DeviceShape> take_shapes() { return std::move(shapes_); }

private:
  Vectors on_lumen(const Vectors& force) const {
    Vectors all(lumen_.points.size(), Vec3::Zero());
    for (std::size_t i = 0; i < wall_.vertex.size(); ++i)
      all[wall_.vertex[i]] = force[i];
    return all;
  }

  DeviceShape shape_of(int body, const std::string& name) const {
    const Body& b = system_.body(body);
    const auto part = [&](const Vectors& all) {
      return Vectors(all.begin() + b.first, all.begin() + b.first + b.count);
    };
    DeviceShape shape{
        name,
        part(system_.x),
        b.triangles,
        {part(balance_.pressure), part(balance_.contact), part(balance_.foundation), part(balance_.residual)}};
    for (Triangle& t : shape.triangles)
      for (int& v : t)
        v -= b.first;
    return shape;
  }

  /// Distance from a point to the nearest surface present.
  double clearance(const Vec3& p) const {
    double nearest = 1e300;
    for (int b = 0; b < system_.bodies(); ++b)
      for (const Triangle& t : system_.body(b).triangles) {
        if ((system_.x[t[0]] - p).squaredNorm() > 36.0)
          continue;
        nearest = std::min(nearest,
                           closest_on_triangle(p, system_.x[t[0]], system_.x[t[1]], system_.x[t[2]]).distance_squared);
      }
    return std::sqrt(nearest);
  }

  std::vector<double> start_radii(const RingGrid& grid, const std::vector<Frame>& frames, double crimped) const {
    std::vector<double> radii;
    for (int r = 0; r < grid.rings(); ++r) {
      const double fits = 0.95 * clearance(frames[r].origin) - start_clearance;
      radii.push_back(std::max(0.05, std::min(0.5 * crimped * grid.profile[r], fits)));
    }
    return radii;
  }

  void place_devices(const Step& step) {
    const Vectors moved = moved_points(lumen_, wall_, system_);
    balloons_.clear();
    // stents first: balloons are taken out at the end of the step and must be the last bodies
    std::vector<std::vector<double>> inside(step.devices.size());
    std::vector<std::vector<Frame>> balloon_frames(step.devices.size());
    std::vector<RingGrid> grids;
    for (std::size_t k = 0; k < step.devices.size(); ++k) {
      const Placement& p = step.devices[k];
      const bool is_stent = scene_.stents.contains(p.device);
      const BalloonSpec& balloon = scene_.balloons.at(is_stent ? scene_.stents.at(p.device).balloon : p.device);
      const Path path = follow_wall(reference_paths_.at(p.branch), lumen_, moved);
      const RingGrid grid = balloon_grid(balloon, scene_.numerics.device_edge);
      balloon_frames[k] = path.frames(along(grid, p.centre_s));
      inside[k] = start_radii(grid, balloon_frames[k], balloon.crimped_diameter);
      grids.push_back(grid);
      if (!is_stent)
        continue;
      const StentSpec& spec = scene_.stents.at(p.device);
      const RingGrid rings = stent_grid(spec, scene_.numerics.device_edge);
      const std::vector<Frame> frames = path.frames(along(rings, p.centre_s));
      std::vector<double> radii = start_radii(rings, frames, spec.crimped_diameter);
      Stent stent = add_stent(system_, spec, p.device, rings, frames, radii);
      for (int body = 0; body < stent.body; ++body)
        interactions_.contacts.emplace_back(stent.body, body, scene_.numerics.contact);
      // the balloon lies inside the stent, clear of it
      const double thinnest = *std::min_element(radii.begin(), radii.end());
      for (double& r : inside[k])
        r = std::max(0.04, std::min(r, 0.9 * thinnest - start_clearance));
      result_.stents.push_back({p.device, p.branch, p.centre_s, std::move(stent)});
    }
    for (std::size_t k = 0; k < step.devices.size(); ++k) {
      const Placement& p = step.devices[k];
      const bool is_stent = scene_.stents.contains(p.device);
      const std::string name = is_stent ? scene_.stents.at(p.device).balloon : p.device;
      balloons_.push_back(add_balloon(system_, scene_.balloons.at(name), grids[k], balloon_frames[k], inside[k]));
      for (int body = 0; body < balloons_.front().body; ++body)
        interactions_.contacts.emplace_back(balloons_.back().body, body, scene_.numerics.contact);
    }
  }

  static std::vector<double> along(const RingGrid& grid, double centre_s) {
    std::vector<double> s = grid.s;
    for (double& value : s)
      value += centre_s;
    return s;
  }

  void remove_balloons() {
    while (!balloons_.empty()) {
      const int body = balloons_.back().body;
      std::erase_if(interactions_.contacts,
                    [&](const SurfaceContact& c) { return c.inner() == body || c.outer() == body; });
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
    const RelaxResult r = relax(system_, interactions_, scene_.numerics.integrator, &balance_);
    result_.stages.push_back({step.name, stage.name, seconds_since(start), r});
    std::cerr << step.name << " / " << stage.name << ": " << r.steps << " steps, " << r.cg_iterations
              << " cg iterations, residual " << r.residual << ", " << r.contacts << " contacts, penetration "
              << r.mean_penetration << " mean " << r.maximal_penetration << " max mm, " << result_.stages.back().seconds
              << " s\n";
    if (!r.converged) {
      std::ostringstream value;
      value << "residual " << r.residual << " after " << r.steps << " steps; wanted "
            << scene_.numerics.integrator.residual_tolerance;
      throw common::ComputationError("the deployment did not reach force balance", step.name + " / " + stage.name,
                                     value.str(),
                                     "predilate with a smaller balloon first, refine the lumen, or raise "
                                     "numerics.maximal_steps_per_stage; no lumen is written");
    }
    after_balance(stage, step);
  }

  void after_balance(const Stage& stage, const Step& step) {
    if (stage.ties_stents)
      tie_stents();
    for (StentHistory& h : result_.stents) {
      const double diameter = 2 * mean(ring_radii(system_, h.stent.body, h.stent.grid));
      (stage.with_balloons ? h.inflated_diameter : h.final_diameter) = diameter;
    }
    if (stage.pressure_fraction == 1.0)
      for (std::size_t k = 0; k < balloons_.size(); ++k)
        shapes_.push_back(
            shape_of(balloons_[k].body, step.name + "_balloon" + (balloons_.size() > 1 ? std::to_string(k + 1) : "")));
  }

  void tie_stents() {
    const Vectors normals = area_vectors(system_);
    std::vector<ContactPoint> points;
    for (SurfaceContact& contact : interactions_.contacts)
      if (contact.outer() == 0 && is_stent(contact.inner()))
        contact.detect(system_, normals, points);
    for (const ContactPoint& p : points)
      interactions_.ties.push_back(tie_of(p, system_.x, scene_.numerics.tie_stiffness));
  }

  bool is_stent(int body) const { return system_.body(body).name == "stent"; }

  void read_malapposition() {
    result_.malapposition.assign(lumen_.points.size(), 0.0);
    const Vectors normals = area_vectors(system_);
    for (const StentHistory& h : result_.stents) {
      const Body& body = system_.body(h.stent.body);
      for (std::size_t i = 0; i < wall_.vertex.size(); ++i) {
        double nearest = 1e300, gap = 0;
        for (const Triangle& t : body.triangles) {
          if ((system_.x[t[0]] - system_.x[i]).squaredNorm() > 4.0)
            continue;
          const ClosestPoint c = closest_on_triangle(system_.x[i], system_.x[t[0]], system_.x[t[1]], system_.x[t[2]]);
          const bool inside = c.weights.minCoeff() > 0; // a foot on the stent's end faces no strut
          if (c.distance_squared < nearest) {
            nearest = c.distance_squared;
            gap = inside ? (system_.x[i] - c.weights[0] * system_.x[t[0]] - c.weights[1] * system_.x[t[1]] -
                            c.weights[2] * system_.x[t[2]])
                               .dot(normals[t[0]].normalized())
                         : 0.0;
          }
        }
        double& value = result_.malapposition[wall_.vertex[i]];
        value = std::max(value, std::max(0.0, gap));
      }
    }
  }

  const Scene& scene_;
  const Lumen& lumen_;
  const std::map<std::string, Path>& reference_paths_;
  System system_;
  Wall wall_;
  Interactions interactions_;
  Balance balance_; ///< of the last stage
  std::vector<Balloon> balloons_;
  std::vector<DeviceShape> shapes_;
  Deployment result_;
};

} // namespace

Deployment deploy(const Scene& scene, const Lumen& lumen, const std::map<std::string, Path>& paths) {
  Run run(scene, lumen, paths);
  for (const Step& step : scene.procedure)
    run.step(step);
  Deployment result = run.finish();
  result.balloons = run.take_shapes();
  return result;
}

} // namespace vci
