// Lumens that no artery has, or that do not fit their centreline, are refused with the place of the fault. Legitimate
// lumens pass.
#include "common/error.hpp"
#include "tests/unit/vci/vessel.hpp"
#include "vci/scene/checks/lumen_check.hpp"
#include <algorithm>
#include <gtest/gtest.h>

namespace {

using namespace vci;
using vci::tests::Vessel;

using Paths = std::map<std::string, Path>;

Scene scene_with(double stent_centre, double length = 8) {
  Scene scene;
  scene.file = "scene.json";
  scene.lumen = "lumen.vtp";
  scene.centreline = "centreline.vtp";
  scene.balloons["balloon"] = {3, length, 1, 0.8, 14, {2, 14}, {2.5, 2.9}};
  scene.stents["stent"] = {3, length, 1.0, 4.4, 0.08, 8, 2, "balloon", 12, 0.5, 20, 0.22, 4.5};
  scene.procedure = {{"one", Action::stent, {{"stent", "main", stent_centre, 11}}}};
  return scene;
}

/// Message of the check; empty if the lumen passes.
std::string refusal(const Lumen& lumen, const Paths& paths, const Scene& scene = scene_with(10)) {
  try {
    check_lumen(scene, lumen, paths);
    return "";
  } catch (const common::InputError& e) {
    return e.what();
  }
}

std::string refusal(const Lumen& lumen) {
  return refusal(lumen, {{"main", Vessel().axis()}});
}

void expect_words(const std::string& message, std::initializer_list<const char*> words) {
  for (const char* w : words)
    EXPECT_NE(message.find(w), std::string::npos) << w << " is missing in: " << message;
}

TEST(LumenCheck, PassesWhatVesselsMayBe) {
  const Vessel plain;
  EXPECT_EQ(refusal(plain.lumen()), "");
  EXPECT_EQ(refusal(plain.closed()), "") << "with caps";
  for (double lesion_offset : {0.0, 1.2}) { // narrowed by nine tenths: a throat on the axis, then at one side
    Vessel severe;
    severe.narrowing = 0.9;
    severe.lesion_offset = lesion_offset;
    severe.rows = 96;
    EXPECT_EQ(refusal(severe.lumen(), {{"main", severe.axis()}}), "") << lesion_offset;
  }
  EXPECT_EQ(refusal(plain.lumen(), {{"main", plain.axis(1.5, 18)}}), "") << "a centreline that ends early";
}

TEST(LumenCheck, NamesTheTriangleThatIsTurned) {
  Lumen one = Vessel().lumen(), half = one, all = one;
  std::swap(one.triangles[500][0], one.triangles[500][1]);
  expect_words(refusal(one), {"turned against their neighbours", "lumen.vtp: triangle 500 at (", "3 neighbours"});
  for (std::size_t k = 0; k < half.triangles.size(); k += 2)
    std::swap(half.triangles[k][0], half.triangles[k][1]);
  expect_words(refusal(half), {"turned against their neighbours"});
  for (Triangle& t : all.triangles)
    std::swap(t[0], t[1]);
  expect_words(refusal(all), {"face its axis", "1536 of 1536"});
}

TEST(LumenCheck, RefusesWhatIsNoSurface) {
  const Lumen whole = Vessel().lumen();
  Lumen twice = whole;
  twice.triangles.push_back({whole.triangles[7][1], whole.triangles[7][2], whole.triangles[7][0]});
  twice.region.push_back(0);
  expect_words(refusal(twice), {"given twice", "triangle 7 at", "triangle 1536"});
  Lumen fin = whole; // a third triangle at an edge of the wall
  fin.points.push_back({0.2, 0.1, 9});
  fin.radius.push_back(1);
  fin.triangles.push_back({whole.triangles[600][0], whole.triangles[600][1], 784});
  fin.region.push_back(0);
  expect_words(refusal(fin), {"more than two triangles", "3 triangles at points 300 and 301"});
  Lumen soup;
  for (const Triangle& t : whole.triangles) {
    const int n = static_cast<int>(soup.points.size());
    for (int v : t) {
      soup.points.push_back(whole.points[v]);
      soup.radius.push_back(whole.radius[v]);
    }
    soup.triangles.push_back({n, n + 1, n + 2});
  }
  soup.region.assign(soup.triangles.size(), 0);
  expect_words(refusal(soup), {"in one place", "merge them"});
  Lumen scattered = soup; // by less than 1 um, so that no two points coincide
  for (std::size_t v = 0; v < soup.points.size(); ++v)
    scattered.points[v] += 1e-7 * static_cast<double>(v) * Vec3(1, 0.3, 0.5);
  expect_words(refusal(scattered), {"in pieces", "1 of its 1536"});
  Lumen flat = whole;
  flat.points[whole.triangles[900][1]] =
      0.5 * (whole.points[whole.triangles[900][0]] + whole.points[whole.triangles[900][2]]);
  expect_words(refusal(flat), {"has no area", "triangle 900 at"});
  flat = whole;
  flat.triangles[900][1] = flat.triangles[900][0];
  expect_words(refusal(flat), {"has no area", "triangle 900 at"});
}

Lumen without_part(Lumen l, double s_start, double s_end, double x_from) {
  Lumen rest = l;
  rest.triangles.clear();
  for (const Triangle& t : l.triangles) {
    const Vec3 c = (l.points[t[0]] + l.points[t[1]] + l.points[t[2]]) / 3;
    if (c[2] < s_start || c[2] > s_end || c[0] < x_from)
      rest.triangles.push_back(t);
  }
  rest.region.assign(rest.triangles.size(), 0);
  return rest;
}

TEST(LumenCheck, TellsHolesFromEnds) {
  const Lumen whole = Vessel().lumen();
  expect_words(refusal(without_part(whole, 4, 6, 0.2)), {"has a hole", "point", "no branch's axis"});
  EXPECT_EQ(refusal(without_part(whole, 0, 1, 1.2)), "") << "a notch in an end is that end's rim";
  Lumen touching = whole; // two holes that share point 323 and nothing else
  const auto at_323 = [](const Triangle& t) { return std::find(t.begin(), t.end(), 323) != t.end(); };
  const auto one = std::find_if(touching.triangles.begin(), touching.triangles.end(), at_323);
  const auto other = std::find_if(one + 1, touching.triangles.end(), [&](const Triangle& t) {
    return at_323(t) && std::count_if(t.begin(), t.end(),
                                      [&](int v) { return std::find(one->begin(), one->end(), v) != one->end(); }) == 1;
  });
  touching.triangles.erase(other);
  touching.triangles.erase(one);
  expect_words(refusal(touching), {"meet in one point", "point 323 at"});
  expect_words(refusal(without_part(whole, 12, 13, -9)), {"in pieces"});
  Lumen uncapped = Vessel().closed();
  uncapped.region.assign(uncapped.region.size(), 0);               // the caps count as wall
  expect_words(refusal(uncapped), {"does not fit its radius_mm"}); // a cap's middle is on the axis
}

TEST(LumenCheck, ComparesTheWallWithItsRadiusAndTheAxis) {
  const Lumen whole = Vessel().lumen();
  Lumen wide = whole, narrow = whole, one = whole, metres = whole, lesion_offset = whole, spike = whole, slid = whole;
  for (double& r : narrow.radius)
    r /= 4;
  expect_words(refusal(narrow), {"does not fit its radius_mm"});
  one.radius[200] /= 4;
  expect_words(refusal(one), {"does not fit its radius_mm", "point 200 at", "1 of 784"});
  for (double& r : wide.radius)
    r *= 5;
  expect_words(refusal(wide), {"does not fit its radius_mm", "radius_mm 7.5"});
  for (Vec3& p : metres.points)
    p *= 1e-3;
  expect_words(refusal(metres), {"does not fit its radius_mm", "in mm"});
  for (Vec3& p : lesion_offset.points)
    p[0] += 1;
  expect_words(refusal(lesion_offset), {"does not fit its radius_mm", "lumen.vtp: point"});
  spike.points[200][0] += 12;
  expect_words(refusal(spike), {"far longer than the lumen is wide", "200"});
  slid.points[200][2] += 8;
  expect_words(refusal(slid), {"far longer than the lumen is wide", "200"});
}

TEST(LumenCheck, AFlatLumenMayBeManyTimesAsWideAsItsSphere) {
  for (double flat : {4.6, 5.8, 9.0}) { // the slits of real compressed arteries: 4.7 x 1.1 and 5.0 x 1.2 mm
    Lumen slit = Vessel().lumen();
    for (Vec3& p : slit.points)
      p[0] /= flat;
    for (double& r : slit.radius)
      r /= flat;
    EXPECT_EQ(refusal(slit), "") << flat;
  }
}

TEST(LumenCheck, AMainBranchFromTheOutletIsTurned) {
  const Vessel v;
  Vectors back = v.axis().points();
  std::reverse(back.begin(), back.end());
  expect_words(refusal(v.closed(), {{"main", Path(back, 0)}}),
               {"does not start at the inlet", "centreline.vtp: branch main"});
  EXPECT_EQ(refusal(v.lumen(), {{"main", Path(back, 0)}}), "") << "without caps either end may be the inlet";
}

TEST(LumenCheck, DevicesEndWithinTheLumen) {
  const Vessel v;
  const Lumen cut = without_part(v.lumen(), 13, 99, -9);
  const Paths paths{{"main", v.axis()}};
  EXPECT_EQ(refusal(cut, paths, scene_with(6)), "") << "the centreline may go on";
  EXPECT_EQ(refusal(cut, paths, scene_with(8.9)), "") << "within the rim's own length";
  expect_words(
      refusal(cut, paths, scene_with(10)),
      {"past the end of the lumen", "scene.json: scene.procedure[0].devices[0] (step one, stent)", "from 6 to 14 mm"});
  expect_words(refusal(cut, paths, scene_with(17)), {"a device reaches past the end of the lumen"});
  Scene reported = scene_with(6);
  reported.segment = Segment{"main", 2, 12.5};
  EXPECT_EQ(refusal(cut, paths, reported), "");
  reported.segment->s_end = 16;
  expect_words(refusal(cut, paths, reported),
               {"the segment reaches past the end of the lumen", "scene.json: scene.segment"});
}

} // namespace
