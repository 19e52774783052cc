#include "measure/section_noise.hpp"
#include <gtest/gtest.h>
#include <random>

using namespace anatomy;

namespace {

constexpr double length = 40;

double throat(double s) { // 66 % by diameter, 8 mm long
  return 1.5 * (1 - 0.66 * (std::abs(s - 20) < 4 ? std::pow(std::cos(pi * (s - 20) / 8), 2) : 0));
}

double taper(double s) {
  return 0.8 - 0.01 * s;
}

struct Cut {
  std::vector<Branch> branches;
  std::vector<Section> sections;
  double (*radius)(double);
};

// Sections of a vessel of radius r(s), with the scatter that 0.05 mm of noise on vertices 0.2 mm apart gives.
Cut cut(double step, double noise, unsigned seed, double (*radius)(double) = throat, double last = length) {
  Cut out{{}, {}, radius};
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Branch branch;
  for (double s = 0; s <= last; s += step) {
    branch.s.push_back(s);
    branch.x.emplace_back(s, 0, 0);
    branch.radius.push_back(radius(s));
    Section section;
    section.sample = branch.s.size() - 1;
    section.scatter = noise * std::sqrt(0.2 / (2 * pi * radius(s)));
    const double r = radius(s) + section.scatter * normal(random);
    section.area = pi * r * r;
    section.min_diameter = 1.9 * r;
    section.max_diameter = 2.1 * r;
    section.flag = s < 2 || s > last - 2  ? SectionFlag::end
                   : std::abs(s - 30) < 1 ? SectionFlag::ostium
                                          : SectionFlag::ok;
    out.sections.push_back(section);
  }
  out.branches.push_back(branch);
  return out;
}

double scatter(const Cut& c) {
  double sum = 0, squares = 0, n = 0;
  for (const Section& section : c.sections)
    if (section.flag == SectionFlag::ok) {
      const double ratio = section.area / (pi * std::pow(c.radius(c.branches[0].s[section.sample]), 2));
      sum += ratio;
      squares += ratio * ratio;
      ++n;
    }
  return std::sqrt(squares / n - sum * sum / n / n);
}

TEST(SectionNoise, LeavesAreasWithoutNoiseToTheBit) {
  for (double step : {0.25, 0.5}) {
    Cut given = cut(step, 0, 1);
    EXPECT_LT(area_noise(given.sections), 1e-3);
    const std::vector<Section> before = given.sections;
    std::vector<Repair> notes;
    smooth_noisy_areas(given.branches, given.sections, notes);
    EXPECT_TRUE(notes.empty());
    for (std::size_t i = 0; i < before.size(); ++i)
      EXPECT_EQ(given.sections[i].area, before[i].area);
  }
}

constexpr unsigned drawn_walls = 60;

TEST(SectionNoise, IsFound) {
  const double expected = 2 * 0.05 / 1.5 * std::sqrt(0.2 / (2 * pi * 1.5));
  for (double step : {0.25, 0.5})
    EXPECT_NEAR(area_noise(cut(step, 0.05, 1).sections) / expected, 1, 0.01) << step;
}

// In an intravascular pull-back each outline is smooth, but the sizes change from frame to frame.
TEST(SectionNoise, IsNotWhatChangesAlongTheVessel) {
  Cut given = cut(0.5, 0.05, 1);
  for (Section& section : given.sections)
    section.scatter = 0.001;
  EXPECT_LT(area_noise(given.sections), least_area_noise);
  const std::vector<Section> before = given.sections;
  std::vector<Repair> notes;
  smooth_noisy_areas(given.branches, given.sections, notes);
  EXPECT_TRUE(notes.empty());
  for (std::size_t i = 0; i < before.size(); ++i)
    EXPECT_EQ(given.sections[i].area, before[i].area);
}

TEST(SectionNoise, IsTakenOutButNotTheLesion) {
  const double throat_noise = 0.05 * std::sqrt(0.2 / (2 * pi * throat(20))) / throat(20);
  for (double step : {0.25, 0.5}) {
    double squares_before = 0, squares_after = 0, squares_at_throat = 0;
    for (unsigned seed = 1; seed <= drawn_walls; ++seed) {
      Cut given = cut(step, 0.05, seed);
      const std::vector<Section> cut_areas = given.sections;
      const double before = scatter(given);
      std::vector<Repair> notes;
      smooth_noisy_areas(given.branches, given.sections, notes);
      ASSERT_EQ(notes.size(), 1u);
      const double after = scatter(given);
      EXPECT_LT(after, before) << step << " mm, seed " << seed;
      squares_before += before * before;
      squares_after += after * after;
      for (std::size_t i = 0; i < given.sections.size(); ++i) {
        const Section& section = given.sections[i];
        if (section.flag != SectionFlag::ok) {
          EXPECT_EQ(section.area, cut_areas[i].area);
        }
        EXPECT_NEAR(section.min_diameter / section.equivalent_diameter(), 0.95, 1e-9);
        if (std::abs(given.branches[0].s[i] - 20) < 0.01)
          squares_at_throat += std::pow(section.equivalent_diameter() / 2 / throat(20) - 1, 2) / drawn_walls;
      }
    }
    EXPECT_LT(std::sqrt(squares_after / squares_before), 0.8) << step;
    EXPECT_LT(std::sqrt(squares_at_throat), throat_noise) << step; // no worse than before smoothing
  }
}

// The stiffest spline with a penalty on third differences is a parabola. Still a branch that only tapers must mostly
// stay straight.
TEST(SectionNoise, LeavesATaperStraight) {
  unsigned straight = 0;
  for (unsigned seed = 1; seed <= drawn_walls; ++seed) {
    Cut given = cut(0.5, 0.05, seed, taper, 30);
    std::vector<Repair> notes;
    smooth_noisy_areas(given.branches, given.sections, notes);
    double bend = 0;
    for (std::size_t i = 10; i < 40; ++i)
      bend = std::max(bend, std::abs(given.sections[i - 1].equivalent_diameter() +
                                     given.sections[i + 1].equivalent_diameter() -
                                     2 * given.sections[i].equivalent_diameter()));
    straight += bend < 1e-9;
  }
  EXPECT_GT(straight, drawn_walls / 2) << straight;
}

} // namespace
