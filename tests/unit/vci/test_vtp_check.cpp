// Damaged .vtp files are refused before VTK's reader gets them. The reader would crash, hang, or accept false data.
#include "common/error.hpp"
#include "vci/scene/files/reading.hpp"
#include <fstream>
#include <gtest/gtest.h>
#include <unistd.h>

namespace {

using namespace vci;

const std::string triangle = R"(<?xml version="1.0"?>
<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt32">
<PolyData>
<FieldData><DataArray type="Float64" Name="time" NumberOfTuples="1" format="ascii">2.5</DataArray></FieldData>
<Piece NumberOfPoints="3" NumberOfPolys="1">
<PointData><DataArray type="Float64" Name="radius_mm" format="ascii">1 2 3
<InformationKey name="L2_NORM_RANGE" location="vtkDataArray" length="2">
<Value index="0">1</Value><Value index="1">3</Value></InformationKey></DataArray></PointData>
<CellData><DataArray type="Int32" Name="region_id" format="ascii">7</DataArray></CellData>
<Points><DataArray type="Float32" Name="Points" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 0 1 0</DataArray></Points>
<Polys><DataArray type="Int64" Name="connectivity" format="ascii">0 1 2</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">3</DataArray></Polys>
</Piece>
</PolyData>
</VTKFile>
)";

/// The file `triangle` with one text replaced by another.
std::string with_replaced(const std::string& from, const std::string& to) {
  std::string text = triangle;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

/// Message of the refusal; empty if the file is read.
std::string refusal_of(const std::string& text) {
  const auto file = std::filesystem::path(testing::TempDir()) / ("vci_check_" + std::to_string(::getpid()) + ".vtp");
  std::ofstream(file) << text;
  std::string message;
  try {
    const auto data = read_polydata(file, "lumen");
    EXPECT_EQ(data->GetNumberOfPoints(), 3);
    EXPECT_EQ(data->GetNumberOfPolys(), 1);
  } catch (const common::InputError& e) {
    message = e.what();
    EXPECT_NE(message.find("remedy:"), std::string::npos);
  }
  std::filesystem::remove(file);
  return message;
}

void expect_refused(const std::string& text, const std::string& reason) {
  EXPECT_NE(refusal_of(text).find(reason), std::string::npos) << reason << ", but: " << refusal_of(text);
}

/// The file `triangle` with its radii as base64.
std::string with_binary_radii(const std::string& radii) {
  return with_replaced(R"(format="ascii">1 2 3)", R"(format="binary">)" + radii);
}

/// The file `triangle` with a compressed array in place of its radii. @param header the array's header as base64
std::string with_compressed_radii(const std::string& header) {
  const std::string from = R"(<DataArray type="Float64" Name="radius_mm" format="ascii">1 2 3)";
  std::string text = with_replaced(from, R"(<DataArray type="Float64" Name="radius_mm" format="binary">)" + header);
  const std::string root = R"(header_type="UInt32")";
  return text.replace(text.find(root), root.size(), root + R"( compressor="vtkZLibDataCompressor")");
}

TEST(VtpCheck, ReadsAFileThatHoldsWhatItClaims) {
  EXPECT_EQ(refusal_of(triangle), "");
}

TEST(VtpCheck, RefusesMorePointsCellsOrComponentsThanThereAreValues) {
  expect_refused(with_replaced(R"(NumberOfPoints="3")", R"(NumberOfPoints="4")"), "fewer data than the element claims");
  expect_refused(with_replaced(R"(NumberOfPoints="3")", R"(NumberOfPoints="3000000000")"),
                 "more values than the file has bytes");
  expect_refused(with_replaced(R"(NumberOfPoints="3")", R"(NumberOfPoints="9000000000000000000")"),
                 "more values than any");
  expect_refused(with_replaced(R"(NumberOfPoints="3")", R"(NumberOfPoints="-3")"), "negative");
  expect_refused(with_replaced(R"(NumberOfPolys="1")", R"(NumberOfPolys="2")"), "fewer data than the element claims");
  expect_refused(with_replaced(R"(format="ascii">3<)", R"(format="ascii">3000000000<)"),
                 "more values than the file has bytes");
  expect_refused(with_replaced(R"(format="ascii">3<)", R"(format="ascii">-3<)"), "offsets that do not rise");
  // VTK would ask for the name of each component
  expect_refused(with_replaced(R"(Name="region_id")", R"(Name="region_id" NumberOfComponents="2000000000")"),
                 "components");
}

TEST(VtpCheck, RefusesWhatMakesTheReaderFollowNullPointers) {
  std::string text =
      with_replaced("format=\"ascii\">7<", "format=\"ascii\"><"); // the cell data end early, and no point data
  text.replace(text.find("<PointData>"), 11, "<SomeData >");
  text.replace(text.find("</PointData>"), 12, "</SomeData >");
  expect_refused(text, "fewer data than the element claims: region_id");
}

TEST(VtpCheck, ChecksEveryPiece) {
  const std::size_t start = triangle.find("<Piece"), end = triangle.find("</PolyData>");
  const std::string piece = triangle.substr(start, end - start);
  std::string damaged = piece;
  damaged.replace(damaged.find("format=\"ascii\">7<"), 17, "format=\"ascii\"><");
  expect_refused(std::string(triangle).insert(end, damaged), "fewer data than the element claims");
  expect_refused(std::string(triangle).erase(start, end - start), "no piece");
}

TEST(VtpCheck, RefusesTextsBeyondTheirArray) {
  const std::string names = R"(<CellData><DataArray type="String" Name="branch_name" format="ascii">)";
  const std::string main = "109 97 105 110 0 "; // "main" as VTK writes it: its character codes and a 0
  EXPECT_EQ(refusal_of(with_replaced("<CellData>", names + main + "</DataArray>")), "");
  expect_refused(with_replaced("<CellData>", names + main + main + main + "</DataArray>"), "another number of texts");
  expect_refused(with_replaced("<CellData>", names + "109 97</DataArray>"), "another number of texts");
}

TEST(VtpCheck, RefusesElementsDeepInOneAnother) {
  std::string open, close;
  for (int k = 0; k < 300000; ++k) {
    open += "<a>";
    close += "</a>";
  }
  expect_refused(with_replaced("<PointData>", open + close + "<PointData>"), "deep in one another");
}

TEST(VtpCheck, RefusesBlocksThatCannotBe) {
  // The header has words of 4 bytes: number of blocks, bytes of a block, bytes of the last block, compressed bytes of
  // each block.
  expect_refused(with_compressed_radii("AQAAAAAAAAAYAAAAEAAAAA=="), "a block of data of no size"); // 1, 0, 24, 16
  expect_refused(with_compressed_radii("AgAAAAgAAAAYAAAAEAAAABAAAAA="), "larger than the others"); // 2, 8, 24, 16, 16
  expect_refused(with_compressed_radii("AAAAAAAAAAAYAAAA"), "a block of data that is not there");  // 0, 0, 24
  expect_refused(with_compressed_radii("////fwAAAQAYAAAAEAAAAA=="), "more blocks than the file");  // 2^31 - 1, ...
  expect_refused(with_compressed_radii("AQAAAP///38AAAAAEAAAAA=="),
                 "claim to hold more than they can");                                        // 1, 2^31 - 1, 0, 16
  expect_refused(with_compressed_radii("AQAAAAAAAQAYAAAA////fw=="), "larger than the file"); // 1, 2^16, 24, 2^31 - 1
}

TEST(VtpCheck, RefusesDataThatEndBeforeTheirLength) {
  const std::string radii = "GAAAAAAAAAAAAPA/AAAAAAAAAEAAAAAAAAAIQA=="; // 24 bytes, and 1, 2, 3
  EXPECT_EQ(refusal_of(with_binary_radii(radii)), "");
  expect_refused(with_binary_radii(radii.substr(0, 20)),
                 "data that end before their length: radius_mm");                      // VTK reads what it finds
  expect_refused(with_binary_radii("AAAAAA=="), "fewer data than the element claims"); // 0 bytes
}

} // namespace
