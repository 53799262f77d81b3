// SPDX-License-Identifier: MIT
#include "gyrobudget/app/report/gnuplot.h"
#include "gyrobudget/app/report/report.h"
#include "gyrobudget/app/text/error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include "fixtures.h"

namespace gyrobudget::report {
namespace {

namespace fs = std::filesystem;

/// An empty folder of its own, gone with the test.
class Plot : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "gyrobudget-plot-XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] std::string path(const std::string& name) const { return (folder_ / name).string(); }
  [[nodiscard]] long files() const { return std::distance(fs::directory_iterator(folder_), fs::directory_iterator()); }

  fs::path folder_;
};

std::string content(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Another PATH for the length of a scope.
class SearchPath {
 public:
  explicit SearchPath(const std::string& path) : before_(getenv("PATH")) { setenv("PATH", path.c_str(), 1); }
  ~SearchPath() { setenv("PATH", before_.c_str(), 1); }
  SearchPath(const SearchPath&) = delete;
  SearchPath& operator=(const SearchPath&) = delete;

 private:
  std::string before_;
};

template <typename Error, typename Action>
std::string message_of(Action action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "(nothing was thrown)";
}

constexpr std::size_t kTrivial = 5000;  // bytes; an empty frame is smaller

TEST_F(Plot, WritesEveryFormat) {
  const LogResult result = fixtures::mems();
  write_plot(result, path("a.svg"));
  write_plot(result, path("a.png"));
  write_plot(result, path("a.PDF"));
  const std::string svg = content(path("a.svg")), png = content(path("a.png")), pdf = content(path("a.PDF"));
  EXPECT_EQ(svg.rfind("<?xml", 0), 0U);
  EXPECT_NE(svg.find("</svg>"), std::string::npos);
  EXPECT_EQ(png.rfind("\x89PNG\r\n\x1a\n", 0), 0U);
  EXPECT_NE(png.find("IEND"), std::string::npos);
  EXPECT_EQ(pdf.rfind("%PDF-", 0), 0U);
  EXPECT_NE(pdf.find("%%EOF"), std::string::npos);
  for (const auto& file : {svg, png, pdf}) EXPECT_GT(file.size(), kTrivial);
  EXPECT_EQ(files(), 3);
}

TEST_F(Plot, NamesWhatItShows) {
  write_plot(fixtures::accelerometer(), path("a.svg"));
  const std::string svg = content(path("a.svg"));
  for (const char* text :
       {"acc_z", "Allan deviation [ug]", "averaging time", "velocity random walk: N = 0.0200 m/s/sqrt(h)",
        "bias instability: B = 12.0 ug", "acceleration random walk: K = 20.0 ug/sqrt(h)", "95 % interval",
        "sum of the terms", "measured", "not used", "min", "described within 3.1 %"}) {
    EXPECT_NE(svg.find(text), std::string::npos) << text;
  }
}

TEST_F(Plot, DrawsEveryKindOfResult) {
  int i = 0;
  for (const LogResult& result :
       {fixtures::imu(), fixtures::mems_curve_only(), fixtures::bounded(), fixtures::not_described()}) {
    const std::string name = path(std::to_string(i++) + ".svg");
    write_plot(result, name);
    const std::string svg = content(name);
    EXPECT_GT(svg.size(), kTrivial);
    for (const AxisResult& axis : result.axes) EXPECT_NE(svg.find(axis.name), std::string::npos);
  }
}

TEST_F(Plot, SameResultSameBytes) {
  for (const char* ending : {".svg", ".png", ".pdf"}) {
    write_plot(fixtures::mems(), path(std::string("a") + ending));
    write_plot(fixtures::mems(), path(std::string("b") + ending));
    EXPECT_EQ(content(path(std::string("a") + ending)), content(path(std::string("b") + ending))) << ending;
  }
  EXPECT_NE(content(path("a.pdf")).find("/CreationDate (D:19700101000000"), std::string::npos);
}

TEST_F(Plot, NamesAreTextAndNeverCommands) {
  const fs::path before = fs::current_path();
  fs::current_path(folder_);
  write_plot(fixtures::hostile_names(), "a.svg");
  fs::current_path(before);
  EXPECT_EQ(files(), 1);  // nothing was touched
  EXPECT_NE(content(path("a.svg")).find("gyro_{x}^2&lt;/script>"), std::string::npos);
}

TEST(GnuplotString, QuotesWhatWouldEndIt) {
  EXPECT_EQ(gnuplot_string("a'b"), "'a''b'");
  EXPECT_EQ(gnuplot_string("a\nb\x7f"), "'a b '");
  EXPECT_EQ(gnuplot_string("\\`@"), "'\\`@'");
}

TEST_F(Plot, UnknownEndingIsRefusedBeforeAnythingIsDrawn) {
  const SearchPath none(folder_.string());
  for (const char* name : {"a.jpg", "a", "a.svg.gz"}) {
    const auto message = message_of<std::invalid_argument>([&] { write_plot(fixtures::mems(), path(name)); });
    EXPECT_NE(message.find(".svg, .png or .pdf"), std::string::npos) << message;
    EXPECT_NE(message.find(name), std::string::npos) << message;
  }
  EXPECT_EQ(files(), 0);
}

TEST_F(Plot, MissingGnuplotNamesThePackage) {
  const SearchPath none(folder_.string());
  const auto message = message_of<text::OutputError>([&] { write_plot(fixtures::mems(), path("a.png")); });
  EXPECT_NE(message.find("gnuplot-nox"), std::string::npos) << message;
  EXPECT_EQ(files(), 0);
}

TEST_F(Plot, AFailingGnuplotIsQuoted) {
  std::ofstream(path("gnuplot")) << "#!/bin/sh\necho 'half a picture'\necho 'unknown terminal type' >&2\nexit 1\n";
  fs::permissions(path("gnuplot"), fs::perms::owner_all);
  const SearchPath fake(folder_.string());
  const auto message = message_of<text::OutputError>([&] { write_plot(fixtures::mems(), path("a.png")); });
  EXPECT_NE(message.find("unknown terminal type"), std::string::npos) << message;
  EXPECT_FALSE(fs::exists(path("a.png")));
}

TEST_F(Plot, UnwritableTargetIsAnOutputError) {
  EXPECT_THROW(write_plot(fixtures::mems(), path("no/such/folder/a.png")), text::OutputError);
  fs::create_directory(path("folder.png"));
  EXPECT_THROW(write_plot(fixtures::mems(), path("folder.png")), text::OutputError);
  EXPECT_EQ(files(), 1);
}

TEST_F(Plot, AnAxisThatNeverVariesLeavesTheOthers) {
  LogResult result = fixtures::imu();
  ASSERT_GT(result.axes.size(), 1U);
  for (auto& point : result.axes.front().points) point.deviation = point.lower = point.upper = 0;
  write_plot(result, path("a.svg"));
  const std::string svg = content(path("a.svg"));
  EXPECT_EQ(svg.find(result.axes.front().name), std::string::npos);
  EXPECT_NE(svg.find(result.axes.back().name), std::string::npos);
}

TEST_F(Plot, NothingToDrawIsSaid) {
  LogResult result = fixtures::mems();
  result.axes.front().points.clear();
  const auto message = message_of<std::invalid_argument>([&] { write_plot(result, path("a.png")); });
  EXPECT_NE(message.find("no curve to draw"), std::string::npos) << message;
}

}  // namespace
}  // namespace gyrobudget::report
