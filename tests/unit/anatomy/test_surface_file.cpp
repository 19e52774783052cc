#include "common/error.hpp"
#include "files/surface_file.hpp"
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>

using namespace anatomy;
namespace fs = std::filesystem;

namespace {

class SurfaceFile : public ::testing::Test {
protected:
  fs::path folder = fs::temp_directory_path() / ("lumen-test-" + std::to_string(::getpid()));
  void SetUp() override { fs::create_directories(folder); }
  void TearDown() override { fs::remove_all(folder); }

  // an octahedron of the given radius as OBJ
  std::string octahedron(double radius, const std::string& name = "o.obj") {
    std::ofstream file(folder / name);
    for (double sign : {1.0, -1.0})
      for (int k = 0; k < 3; ++k)
        file << "v " << (k == 0) * sign * radius << ' ' << (k == 1) * sign * radius << ' ' << (k == 2) * sign * radius
             << '\n';
    file << "f 1 2 3\nf 2 4 3\nf 4 5 3\nf 5 1 3\nf 2 1 6\nf 4 2 6\nf 5 4 6\nf 1 5 6\n";
    return folder / name;
  }
  std::string message(const std::string& path, LengthUnit unit = LengthUnit::mm) {
    try {
      std::vector<Repair> repairs;
      read_surface(path, unit, {}, repairs);
    } catch (const common::InputError& error) {
      return error.what();
    }
    return "";
  }
};

TEST_F(SurfaceFile, ScalesToMillimetres) {
  std::vector<Repair> repairs;
  const Soup soup = soup_of(read_surface(octahedron(2), LengthUnit::cm, {}, repairs));
  ASSERT_EQ(soup.triangles.size(), 8u);
  EXPECT_NEAR(vec(soup.points[0]).norm(), 20, 1e-5);
  EXPECT_TRUE(soup.region.empty());
}

TEST_F(SurfaceFile, RefusesAnImplausibleScaleWithTheLikelyUnit) {
  EXPECT_NE(message(octahedron(0.02)).find("declare units m"), std::string::npos);
  EXPECT_NE(message(octahedron(20), LengthUnit::m).find("declare units mm"), std::string::npos);
  EXPECT_THROW(check_mean_radius(0.0015, LengthUnit::mm, "file"), common::InputError);
  EXPECT_NO_THROW(check_mean_radius(1.5, LengthUnit::mm, "file"));
}

// A stent's short tube and a heart with its aorta, a distal branch and an ectatic artery are just inside.
TEST_F(SurfaceFile, KeepsWhatLiesJustInsideTheScale) {
  EXPECT_EQ(message(octahedron(1.2)), ""); // diagonal 2 sqrt(3) R = 4.16 mm
  EXPECT_NE(message(octahedron(1.1)).find("expected 4 to 500 mm"), std::string::npos);
  EXPECT_EQ(message(octahedron(144)), ""); // 498.8 mm
  EXPECT_NE(message(octahedron(145)).find("cut away what is no coronary artery"), std::string::npos);
  EXPECT_NO_THROW(check_mean_radius(0.31, LengthUnit::mm, "file"));
  EXPECT_THROW(check_mean_radius(0.29, LengthUnit::mm, "file"), common::InputError);
  EXPECT_NO_THROW(check_mean_radius(5.9, LengthUnit::mm, "file"));
  EXPECT_THROW(check_mean_radius(6.1, LengthUnit::mm, "file"), common::InputError);
}

TEST_F(SurfaceFile, RefusesWhatIsNotASurface) {
  EXPECT_NE(message(folder / "absent.stl").find("no such surface file"), std::string::npos);
  EXPECT_NE(message(octahedron(20, "o.xyz")).find(".xyz"), std::string::npos);
  EXPECT_THROW(length_unit_of("inch"), common::InputError);
  std::ofstream(folder / "empty.stl") << "solid nothing\nendsolid nothing\n";
  EXPECT_NE(message(folder / "empty.stl").find("0 triangles"), std::string::npos);
}

TEST_F(SurfaceFile, AnStlIsTextWhereItsReaderTakesItForText) {
  // text, then other bytes: to VTK's reader it is binary, and the text at its bytes 80 to 83 a count of 900 million
  std::ofstream(folder / "damaged.stl") << "solid " << std::string(100, '8') << std::string(60, '\xb0')
                                        << "\nendsolid\n";
  EXPECT_NE(message(folder / "damaged.stl").find("not that of its triangles"), std::string::npos);
}

TEST_F(SurfaceFile, AHeaderThatOverrunsItsReaderIsRefused) {
  const auto refused = [&](const std::string& line) {
    std::ofstream(folder / "mask.mha") << "ObjectType = Image\nNDims = 3\n" << line << "\nElementDataFile = LOCAL\n";
    return message(folder / "mask.mha");
  };
  EXPECT_NE(refused(std::string(201, 'k') + " = 1").find("line 3"), std::string::npos);
  EXPECT_NE(refused("no key at all").find("no key = value"), std::string::npos);
  EXPECT_NE(refused("Comment = \x01").find("a control character"), std::string::npos);
  EXPECT_EQ(refused(std::string(199, 'k') + "=1").find("line 3"), std::string::npos);
  EXPECT_EQ(refused("\r\n0008|0005 = ISO_IR 100\nComment = a = b: c").find("line"), std::string::npos);
}

TEST_F(SurfaceFile, AFieldOfNrrdNeedsItsBlank) { // VTK's reader passes over it without: of the sizes, of the directions
  const auto refused = [&](const std::string& line) {
    std::ofstream(folder / "mask.nrrd") << "NRRD0004\n# made: by hand\nkey:=value\ncontent:\n" << line << "\n\n";
    return message(folder / "mask.nrrd");
  };
  EXPECT_NE(refused("dimension:3").find("line 5"), std::string::npos);
  EXPECT_NE(refused("space origin:(1,2,3)").find("no blank after the colon"), std::string::npos);
  EXPECT_EQ(refused("dimension: 3").find("no blank"), std::string::npos);
}

TEST_F(SurfaceFile, Sha256OfAKnownText) {
  std::ofstream(folder / "abc") << "abc"; // FIPS 180-2, appendix B.1
  EXPECT_EQ(sha256_of_file(folder / "abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

} // namespace
