#include "measure/lesions.hpp"
#include "measured_tube.hpp"
#include <gtest/gtest.h>

using namespace anatomy;
using shapes::Measured, shapes::measured;

namespace {

TEST(Lesions, FoundWithTheirReference) {
  shapes::Tube tube = shapes::straight(1.6, 40);
  const auto healthy = [](double s) { return 1.6 - 0.01 * s; };
  tube.radius = [&](double s) {
    return std::abs(s - 22) < 5 ? healthy(s) * (1 - 0.5 * 0.5 * (1 + std::cos(pi * (s - 22) / 5))) : healthy(s);
  };
  const Measured out = measured(tube);
  std::vector<Repair> notes;
  const auto lines = reference_profiles(out.branches, out.sections, notes);
  EXPECT_TRUE(notes.empty());
  EXPECT_NEAR(lines[0].diameter(22), 2 * healthy(22), 0.03 * 2 * healthy(22));
  const auto lesions = find_lesions(out.branches, out.sections, lines);
  ASSERT_EQ(lesions.size(), 1u);
  EXPECT_NEAR(lesions[0].diameter_stenosis, 50, 1.5);
  EXPECT_NEAR(lesions[0].area_stenosis, 75, 1.5);
  EXPECT_NEAR(lesions[0].s_mla, 22, 0.5);
  EXPECT_NEAR(lesions[0].s_start, 18, 1);
  EXPECT_NEAR(lesions[0].s_end, 26, 1);
  EXPECT_GT(lesions[0].proximal_reference, lesions[0].distal_reference);
}

// Lesions of a straight vessel of 3 mm. It is narrowed by 60 % from 10 to 15 mm, by 40 % from 20 to 25 mm, and by
// `between` per cent from 15 to 20 mm. mouth: whether a side branch's mouth widens the sections from 15 to 20 mm.
std::vector<Lesion> two_narrowings(double between, bool mouth) {
  std::vector<Branch> branches(1);
  std::vector<Section> sections;
  for (std::size_t i = 0; i < 160; ++i) {
    const double s = 0.25 * static_cast<double>(i);
    branches[0].s.push_back(s);
    const double lacking = s < 10 || s > 25 ? 0 : s < 15 ? 60 : s > 20 ? 40 : between;
    Section section;
    section.sample = i;
    section.area = pi / 4 * 9 * (1 - lacking / 100) * (1 - lacking / 100);
    section.flag = mouth && s >= 15 && s <= 20 ? SectionFlag::ostium : SectionFlag::ok;
    sections.push_back(section);
  }
  return find_lesions(branches, sections, {ReferenceProfile{{3, 0}, {}, {}}});
}

TEST(Lesions, PartWhereHalfOfTheLesserNarrowingIsRecovered) {
  const std::vector<Lesion> two = two_narrowings(19, false);
  ASSERT_EQ(two.size(), 2u);
  EXPECT_NEAR(two[0].diameter_stenosis, 60, 1e-9);
  EXPECT_NEAR(two[1].diameter_stenosis, 40, 1e-9);
  EXPECT_LE(two[0].s_end, two[1].s_start);
  EXPECT_EQ(two_narrowings(21, false).size(), 1u);
  EXPECT_EQ(two_narrowings(19, true).size(), 1u);
}

// Sections every 0.25 mm of a straight vessel with the given diameters. Sets the arc lengths of `branch`.
std::vector<Section> sections_every_quarter(Branch& branch, const std::function<double(double)>& diameter,
                                            double length) {
  std::vector<Section> sections;
  for (double s = 0; s <= length; s += 0.25) {
    Section section;
    section.sample = branch.s.size();
    section.area = pi / 4 * diameter(s) * diameter(s);
    section.flag = SectionFlag::ok;
    branch.s.push_back(s);
    sections.push_back(section);
  }
  return sections;
}

TEST(Lesions, MeasuredWhereTheStenosisIsGreatest) {
  // A left main stem is narrowed by 58 %. The thinner vessel behind it is narrowed by 46 %, but its lumen is smaller.
  const ReferenceProfile healthy{{4.4, 0}, {}, ReferenceStep{12, 12, {3.4, 0}}};
  const auto narrowed = [&](double s) {
    return healthy.diameter(s) * (s < 4 || s > 20 ? 1 : s < 8 ? 0.42 : s < 14 ? 0.5 : 0.54);
  };
  std::vector<Branch> branches(1);
  const std::vector<Section> sections = sections_every_quarter(branches[0], narrowed, 40);
  const std::vector<Lesion> lesions = find_lesions(branches, sections, {healthy});
  ASSERT_EQ(lesions.size(), 1u);
  EXPECT_NEAR(lesions[0].diameter_stenosis, 58, 1e-6);
  EXPECT_NEAR(lesions[0].mld, 0.42 * 4.4, 1e-6);
  EXPECT_LT(lesions[0].s_mla, 8);
}

TEST(Lesions, ShorterThanAMillimetreIfTheyHalveTheLumen) {
  const ReferenceProfile healthy{{3, 0}, {}, {}};
  for (const auto& [left, found] : {std::pair{0.45, 1u}, {0.55, 0u}}) {
    const auto web = [left = left](double s) { return 3 * (s > 20 && s < 20.6 ? left : 1); };
    std::vector<Branch> branches(1);
    const std::vector<Section> sections = sections_every_quarter(branches[0], web, 40);
    EXPECT_EQ(find_lesions(branches, sections, {healthy}).size(), found) << left;
  }
}

TEST(Lesions, OfPlacesThatMeasureAlikeTheSmallest) {
  const ReferenceProfile healthy{{4, -0.05}, {}, {}};
  const auto narrowed = [&](double s) { return healthy.diameter(s) * (s < 5 || s > 35 ? 1 : s < 8 ? 0.495 : 0.5); };
  std::vector<Branch> branches(1);
  const std::vector<Section> sections = sections_every_quarter(branches[0], narrowed, 40);
  const std::vector<Lesion> lesions = find_lesions(branches, sections, {healthy});
  ASSERT_EQ(lesions.size(), 1u);
  EXPECT_NEAR(lesions[0].s_mla, 35, 1e-6);
}

TEST(Lesions, NoneInAHealthyTube) {
  shapes::Tube tube = shapes::straight(1.6, 30);
  tube.radius = [](double s) { return 1.6 - 0.01 * s; };
  const Measured out = measured(tube);
  std::vector<Repair> notes;
  EXPECT_TRUE(find_lesions(out.branches, out.sections, reference_profiles(out.branches, out.sections, notes)).empty());
}

// Sections of a main branch with diameters main(s), and of a side branch of constant diameter that leaves at s = 15 mm.
std::vector<Section> sections_of(std::vector<Branch>& branches, const std::function<double(double)>& main,
                                 double side) {
  branches.assign(2, Branch());
  branches[1].id = 1;
  branches[1].parent = 0;
  branches[1].s_on_parent = 15;
  std::vector<Section> sections;
  for (std::size_t b = 0; b < 2; ++b)
    for (std::size_t i = 0; i < 80; ++i) {
      branches[b].s.push_back(0.5 * static_cast<double>(i));
      const double d = b == 0 ? main(branches[b].s.back()) : side;
      Section section;
      section.branch = b;
      section.sample = i;
      section.area = pi / 4 * d * d;
      section.flag = SectionFlag::ok;
      sections.push_back(section);
    }
  return sections;
}

// Adds a second side branch of constant diameter, which leaves at s mm, to the branches of `sections_of`.
void add_side(std::vector<Branch>& branches, std::vector<Section>& sections, double s, double diameter) {
  branches.push_back(branches[1]);
  branches[2].id = 2;
  branches[2].s_on_parent = s;
  for (std::size_t i = 80; i < 160; ++i) {
    Section section = sections[i];
    section.branch = 2;
    section.area = pi / 4 * diameter * diameter;
    sections.push_back(section);
  }
}

TEST(Reference, StepsDownPastASideBranchByTheFlowSplit) {
  const auto healthy = [](double s) {
    const double d = 3.8 - 0.01 * s;
    return s > 15 ? std::pow(std::pow(d, 2.55) - std::pow(2.2, 2.55), 1 / 2.55) : d;
  };
  const auto diseased = [&](double s) { return healthy(s) * (s > 20 && s < 30 ? 0.4 : 1); };
  std::vector<Branch> branches;
  std::vector<Repair> notes;
  const std::vector<Section> sections = sections_of(branches, diseased, 2.2);
  const auto profiles = reference_profiles(branches, sections, notes);
  EXPECT_EQ(profiles[0].sides.branches.size(), 1u);
  for (double s : {5.0, 14.0, 16.0, 25.0, 39.0})
    EXPECT_NEAR(profiles[0].diameter(s), healthy(s), 0.01) << s;
  EXPECT_NEAR(find_lesions(branches, sections, profiles).at(0).diameter_stenosis, 60, 0.5);
}

TEST(Reference, StepsDownByTheFlowSplitWhereTheLumenBeforeTheSideBranchIsNarrowed) {
  const auto healthy = [](double s) {
    const double d = 4.3 - 0.01 * s;
    return s > 15 ? std::pow(std::pow(d, 2.55) - std::pow(3.0, 2.55), 1 / 2.55) : d;
  };
  std::vector<Branch> branches;
  std::vector<Repair> notes;
  const auto diseased = [&](double s) {
    return healthy(s) * (s > 16 ? 1 : 1 - 0.5 * std::exp(-std::pow((s - 8) / 5, 2)));
  };
  const auto profiles = reference_profiles(branches, sections_of(branches, diseased, 3.0), notes);
  for (double s : {2.0, 8.0, 14.0, 20.0, 39.0})
    EXPECT_NEAR(profiles[0].diameter(s), healthy(s), 0.05) << s;
}

TEST(Reference, StepsIntoTheLesserBranchOfAForkBehindSmallBranches) {
  // Like a right coronary artery, the vessel tapers past a small branch without a step. It forks from 3.5 into 2.6 and
  // 2.5 mm, 3 mm before the axes part. The step is deeper than a fork into two equal branches would give.
  const auto healthy = [](double s) { return s < 24 ? 3.7 - 0.008 * s : 2.5 - 0.015 * (s - 24); };
  std::vector<Branch> branches;
  std::vector<Repair> notes;
  std::vector<Section> sections = sections_of(branches, healthy, 1.6);
  add_side(branches, sections, 27, 2.6);
  const auto profiles = reference_profiles(branches, sections, notes);
  for (double s : {1.0, 20.0, 27.0, 39.0})
    EXPECT_NEAR(profiles[0].diameter(s), healthy(s), 0.05) << s;
  EXPECT_TRUE(notes.empty());
}

TEST(Reference, StepsDownByMurraysLawWhereTheVesselDoes) {
  // Two forks follow the power 3. With the power 2.55 the healthy vessel behind the first fork would be 8 % too wide.
  const auto healthy = [](double s) {
    const double trunk = 4.2 - 0.008 * s;
    return std::cbrt(std::pow(trunk, 3) - (s > 15 ? std::pow(3.2, 3) : 0) - (s > 28 ? std::pow(2.2, 3) : 0));
  };
  const auto diseased = [&](double s) { return healthy(s) * (s > 18 && s < 24 ? 0.4 : 1); };
  std::vector<Branch> branches;
  std::vector<Repair> notes;
  std::vector<Section> sections = sections_of(branches, diseased, 3.2);
  add_side(branches, sections, 28, 2.2);
  const auto profiles = reference_profiles(branches, sections, notes);
  EXPECT_EQ(profiles[0].sides.exponent, 3);
  for (double s : {1.0, 14.0, 17.0, 26.0, 39.0})
    EXPECT_NEAR(profiles[0].diameter(s), healthy(s), 0.05) << s;
  EXPECT_TRUE(notes.empty());
}

TEST(Reference, DoesNotStepDownPastABranchThatBringsBlood) {
  // A graft of 2.6 mm joins at 32 mm. If it split the flow, the healthy vessel before it would seem a fifth too narrow.
  const auto healthy = [](double s) {
    const double d = 4.4 - 0.012 * s;
    return s > 15 ? std::pow(std::pow(d, 2.55) - std::pow(3.0, 2.55), 1 / 2.55) : d;
  };
  const auto diseased = [&](double s) { return healthy(s) * (s > 19 && s < 27 ? 0.4 : 1); };
  std::vector<Branch> branches;
  std::vector<Repair> notes;
  std::vector<Section> sections = sections_of(branches, diseased, 3.0);
  add_side(branches, sections, 32, 2.6);
  const auto profiles = reference_profiles(branches, sections, notes);
  for (double s : {1.0, 14.0, 17.0, 30.0, 39.0})
    EXPECT_NEAR(profiles[0].diameter(s), healthy(s), 0.05) << s;
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_EQ(notes[0].what, "reference does not step down past a branch");
  EXPECT_NE(notes[0].detail.find("32.0 mm along it: a branch of 2.60 mm"), std::string::npos) << notes[0].detail;
}

// Reference profile of a single vessel with the given diameters over 40 mm; its warnings go to `notes`.
ReferenceProfile profile_of(const std::function<double(double)>& diameter, std::vector<Repair>& notes) {
  std::vector<Branch> branches;
  std::vector<Section> sections = sections_of(branches, diameter, 1);
  branches.resize(1);
  std::erase_if(sections, [](const Section& section) { return section.branch != 0; });
  return reference_profiles(branches, sections, notes)[0];
}

ReferenceProfile profile_of(const std::function<double(double)>& diameter) {
  std::vector<Repair> notes;
  return profile_of(diameter, notes);
}

// Factor of the diameter: 1 outside a to b, `left` inside, with flanks of 2 mm.
double narrowing(double s, double a, double b, double left) {
  return 1 - (1 - left) * std::clamp(std::min(s - a, b - s) / 2, 0.0, 1.0);
}

TEST(Reference, LiesOnTheHealthyEndsOfALongNarrowing) {
  std::vector<Repair> notes;
  const ReferenceProfile profile = profile_of([](double s) { return 3.4 * narrowing(s, 3, 36, 0.45); }, notes);
  for (double s : {1.0, 20.0, 39.0})
    EXPECT_NEAR(profile.diameter(s), 3.4, 0.02) << s;
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_TRUE(notes[0].warning);
  EXPECT_EQ(notes[0].what, "reference by a short healthy part");
  EXPECT_NE(notes[0].detail.find("for healthy: 1.53 mm there"), std::string::npos) << notes[0].detail;
}

TEST(Reference, OfATaperingVesselWithSeveralNarrowings) {
  const auto healthy = [](double s) { return 4 - 0.05 * s; };
  const ReferenceProfile profile = profile_of([&](double s) {
    return healthy(s) * std::min({narrowing(s, 3, 8, 0.45), narrowing(s, 4, 33, 0.7), narrowing(s, 25, 33, 0.57)});
  });
  for (double s : {1.0, 6.0, 20.0, 39.0})
    EXPECT_NEAR(profile.diameter(s), healthy(s), 0.02) << s;
}

TEST(Reference, IsCarriedOnBehindTheHealthyPart) {
  // From 15 mm to the end the vessel is half as wide. No branch that was left out could explain so deep a step.
  const ReferenceProfile profile = profile_of([](double s) { return 3.4 * narrowing(s, 15, 60, 0.5); });
  for (double s : {1.0, 10.0, 20.0, 39.0})
    EXPECT_NEAR(profile.diameter(s), 3.4, 0.02) << s;
}

TEST(Reference, StepsDownAtABranchThatIsLeftOut) {
  std::vector<Repair> notes;
  const auto healthy = [](double s) { return s < 10 ? 4.6 : 3.6 - 0.02 * (s - 10); };
  const ReferenceProfile profile = profile_of([&](double s) { return healthy(s) * narrowing(s, 18, 28, 0.4); }, notes);
  for (double s : {1.0, 9.0, 12.0, 23.0, 39.0})
    EXPECT_NEAR(profile.diameter(s), healthy(s), 0.02) << s;
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_TRUE(notes[0].warning);
  EXPECT_EQ(notes[0].what, "reference steps down where no branch leaves");
}

TEST(Reference, IsInterpolatedOverAStepThatANarrowingHides) {
  const auto healthy = [](double s) { return s < 15 ? 4.4 : 3.6; };
  const ReferenceProfile profile = profile_of([&](double s) { return healthy(s) * narrowing(s, 11, 19, 0.5); });
  for (double s : {1.0, 10.0, 20.0, 39.0})
    EXPECT_NEAR(profile.diameter(s), healthy(s), 0.02) << s;
  EXPECT_NEAR(profile.diameter(15), 4.0, 0.1);
}

TEST(Reference, LeavesAnEctasiaOut) {
  // The vessel has 1.4 mm before the ectasia and 1 mm behind it. A line through the ectasia would rise up to 4.6 mm.
  const auto vessel = [](double s) { return s < 23 ? 1.4 : 1.0; };
  const ReferenceProfile profile =
      profile_of([&](double s) { return std::max(4.7 - 0.35 * std::abs(s - 23), vessel(s)); });
  EXPECT_LE(profile.line.slope, 0);
  EXPECT_NEAR(profile.diameter(10), 1.4, 0.1);
  EXPECT_LT(profile.diameter(38), 1.45);
}

TEST(Reference, KeepsTheHealthyVesselBetweenANarrowOstiumAndItsEnd) {
  // Narrowed by 60 % up to 10 mm and healthy behind. The healthy part is no ectasia, since nothing narrower follows.
  const auto healthy = [](double s) { return 3 - 0.01 * s; };
  const ReferenceProfile profile = profile_of([&](double s) { return healthy(s) * (s < 10 ? 0.4 : 1); });
  EXPECT_NEAR(profile.diameter(5), healthy(5), 0.05);
  EXPECT_NEAR(profile.diameter(30), healthy(30), 0.02);
}

// In a long vessel lines are drawn through some of the sections only. Here all of these are narrower than the others.
TEST(Reference, IsFoundWhereNoneOfTheWideSectionsIsDrawn) {
  std::vector<Branch> branches(1);
  std::vector<Section> sections(200);
  for (std::size_t i = 0; i < sections.size(); ++i) {
    branches[0].s.push_back(0.25 * static_cast<double>(i));
    const double d = i % 3 == 0 ? 2.0 : 2.6;
    sections[i].sample = i;
    sections[i].area = pi / 4 * d * d;
    sections[i].flag = SectionFlag::ok;
  }
  std::vector<Repair> notes;
  EXPECT_NEAR(reference_profiles(branches, sections, notes)[0].diameter(20), 2.6, 0.05);
}

// Reference profile of a single vessel with the given diameters, from sections at a spacing over its length (mm).
ReferenceProfile profile_at_spacing(double spacing, const std::function<double(double)>& diameter,
                                    std::vector<Repair>& notes, double length = 40) {
  std::vector<Branch> branches(1);
  std::vector<Section> sections(static_cast<std::size_t>(length / spacing));
  for (std::size_t i = 0; i < sections.size(); ++i) {
    branches[0].s.push_back(spacing * static_cast<double>(i));
    sections[i].sample = i;
    sections[i].area = pi / 4 * std::pow(diameter(branches[0].s.back()), 2);
    sections[i].flag = SectionFlag::ok;
  }
  return reference_profiles(branches, sections, notes)[0];
}

TEST(Reference, DoesNotDependOnTheSpacingOfTheSections) {
  // 3 mm of the vessel's start and 3 mm of a dilatation are wide: 12 sections at 0.25 mm, 6 at 0.5 mm
  const auto diameter = [](double s) {
    return (3.0 - 0.01 * s) * (s < 3 || (s > 20 && s < 23) ? 1.2 : 1) * narrowing(s, 28, 36, 0.5);
  };
  std::vector<Repair> notes;
  const ReferenceProfile usual = profile_at_spacing(0.5, diameter, notes);
  for (double spacing : {0.1, 0.25, 1.0})
    for (double s : {1.0, 15.0, 22.0, 32.0, 39.0})
      EXPECT_NEAR(profile_at_spacing(spacing, diameter, notes).diameter(s), usual.diameter(s), 0.03)
          << spacing << " " << s;
}

TEST(Reference, OfAVesselWithoutAHealthyStretchHasAQuarterOfItAbove) {
  // Like a real left artery with a funnel at its start and an ectasia: nowhere do 4 mm of it follow one line.
  const std::vector<double> diameters{4.3, 3.3, 3.6, 2.5, 2.9, 2.2, 2.5, 1.8, 3.9, 1.9, 2.1, 1.5, 1.8, 1.3, 1.3};
  const auto irregular = [&](double s) {
    const auto k = static_cast<std::size_t>(s / 3);
    return std::lerp(diameters[k], diameters[k + 1], s / 3 - static_cast<double>(k));
  };
  for (double spacing : {0.25, 0.5}) {
    std::vector<Repair> notes;
    const ReferenceProfile profile = profile_at_spacing(spacing, irregular, notes);
    ASSERT_EQ(notes.size(), 1u);
    EXPECT_TRUE(notes[0].warning);
    EXPECT_EQ(notes[0].what, "no healthy stretch for the reference");
    int above = 0;
    for (int i = 0; i < 400; ++i)
      above += irregular(0.1 * i) > profile.diameter(0.1 * i);
    EXPECT_NEAR(above, 100, 20);
    EXPECT_LT(profile.diameter(0), 1.25 * 4.3);
  }
}

TEST(Reference, OfAShortBranchNeedsNoLongHealthyStretch) {
  std::vector<Repair> notes;
  const auto rough = [](double s) { return 2.0 * (1 + 0.02 * std::sin(5 * s)); };
  EXPECT_NEAR(profile_at_spacing(0.5, rough, notes, 6).diameter(3), 2.0, 0.05);
  EXPECT_TRUE(notes.empty());
}

TEST(Reference, DoesNotWidenAlongTheVessel) {
  const ReferenceProfile profile = profile_of([](double s) { return 2 + 0.02 * s; });
  EXPECT_EQ(profile.line.slope, 0);
}

TEST(Reference, HasNoStepWhereTheVesselHasNone) {
  std::vector<Branch> branches;
  std::vector<Repair> notes;
  const auto profiles = reference_profiles(branches,
                                           sections_of(
                                               branches, [](double s) { return 3.8 - 0.01 * s; }, 2.2),
                                           notes);
  EXPECT_TRUE(profiles[0].sides.branches.empty());
  EXPECT_NEAR(profiles[0].diameter(30), 3.5, 1e-3);
}

} // namespace
