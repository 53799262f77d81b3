// SPDX-License-Identifier: MIT
// Public recordings against what independent readers found in them: python3-rosbag, sqlite3 with npm's
// rosmsg2-serialization, and @mcap/core; mean and standard deviation (N - 1) to the digits that these give.
#include "gyrobudget/app/log/recording.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include "recording_fixture.h"

namespace gyrobudget::app_tests {
namespace {

std::string real_log(const std::string& name) { return std::string(GYROBUDGET_DATA) + "/logs/" + name; }

#define SKIP_WITHOUT_LOGS()                       \
  if (!std::filesystem::exists(real_log("ros1"))) \
  GTEST_SKIP() << "no public recordings in " << real_log("") << "; set GYROBUDGET_DATA"

using Six = std::array<double, 6>;
const Six kRazor600Mean{0.301787157, 0.263545729, -0.105215530, -0.518938411, 1.81944909, 2.38339583};
const Six kRazor600Std{2.89680, 6.66490, 1.66369, 6.68042, 5.34805, 7.59485};

/// What is known of a stream; a standard deviation of NaN is not.
struct Known {
  std::string file, topic;
  std::int64_t count = 0, first_ns = 0, last_ns = 0;
  Six mean{}, deviation{};
  std::vector<std::string> needs{};  ///< of libraries
};

/// Half of the last of `digits` significant digits of a number, and rounding of the sums.
double half_digit(double value, int digits) {
  return 0.51 * std::pow(10.0, std::floor(std::log10(std::abs(value))) - digits + 1);
}

void compare(const std::vector<double>& column, double mean, double deviation) {
  const auto n = static_cast<double>(column.size());
  const double found = std::accumulate(column.begin(), column.end(), 0.0) / n;
  EXPECT_NEAR(found, mean, half_digit(mean, 9));
  if (std::isnan(deviation)) return;
  double squares = 0;
  for (const double x : column) squares += (x - found) * (x - found);
  EXPECT_NEAR(std::sqrt(squares / (n - 1)), deviation, half_digit(deviation, 6));
}

class RealRecording : public testing::TestWithParam<Known> {};

TEST_P(RealRecording, HoldsWhatIndependentReadersFound) {
  SKIP_WITHOUT_LOGS();
  const Known& known = GetParam();
  if (packings(known.needs).size() != known.needs.size()) GTEST_SKIP() << "a build that cannot unpack it";
  const auto recording = log::open_recording(real_log(known.file));
  ASSERT_NE(recording, nullptr);
  const std::size_t topic = stream(*recording, known.topic);
  EXPECT_EQ(recording->streams()[topic].count, known.count);
  const log::Rows rows = read(*recording, topic, kSixAxes);
  ASSERT_EQ(rows.stamps_ns.size(), static_cast<std::size_t>(known.count));
  EXPECT_EQ(rows.clock, "header.stamp");
  EXPECT_EQ(rows.stamps_ns.front(), known.first_ns);
  EXPECT_EQ(rows.stamps_ns.back(), known.last_ns);
  for (std::size_t i = 0; i < 6; ++i) compare(rows.columns[i], known.mean[i], known.deviation[i]);
}

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
const Six kNoDeviation{kNone, kNone, kNone, kNone, kNone, kNone};
constexpr std::int64_t kRazorFirst = 1352907614798383951;

Known razor_600(const std::string& file, const std::vector<std::string>& needs = {}) {
  return {file, "/imu/data_raw", 600, kRazorFirst, 1352907623752774953, kRazor600Mean, kRazor600Std, needs};
}

const Six kRazorMean{0.0146716386, 0.129144738, 0.019216177, -1.78900682, 3.32404381, 4.86707829};
const Six kRazorStd{1.62439, 3.61794, 1.11962, 5.65121, 3.8747, 4.79006};

INSTANTIATE_TEST_SUITE_P(
    Imu, RealRecording,
    testing::Values(Known{"ros1/jackal_sim_bz2.bag",
                          "/imu/data",
                          3061,
                          47'580'000'000,
                          108'780'000'000,
                          {-0.00428524858, -0.00106796937, 0.0784386675, -0.0180575348, -0.187387655, 9.75061573},
                          {0.0323231, 0.0598059, 0.268646, 1.26864, 0.827787, 0.338058},
                          {"bz2"}},
                    Known{"ros1/razor_bz2.bag",
                          "/imu/data_raw",
                          2144,
                          kRazorFirst,
                          1352907645844156026,
                          kRazorMean,
                          kRazorStd,
                          {"bz2"}},
                    Known{"ros1/razor_lz4.bag",
                          "/imu/data_raw",
                          2144,
                          kRazorFirst,
                          1352907645844156026,
                          kRazorMean,
                          kRazorStd,
                          {"lz4"}},
                    Known{"ros1/razor_none_1000.bag",
                          "/imu/data_raw",
                          1000,
                          kRazorFirst,
                          1352907629416919946,
                          {0.189605285, 0.178622156, -0.0437224707, 0.226051797, 3.23699422, 4.00084445},
                          {2.27182, 5.1636, 1.31538, 5.28643, 5.09966, 6.39427}},
                    Known{"rosbag2/counter_v2",
                          "/imu",
                          1565,
                          1588512872784906481,
                          1588512935344918786,
                          {131, 132, 133, 151, 152, 153},
                          kNoDeviation,
                          {"sqlite"}},
                    Known{"rosbag2/all_types",
                          "/test/sensor_msgs/imu",
                          2,
                          1749315324728548096,
                          1749315324789195008,
                          {0.01, 0.02, 0.03, 0.1, 0.2, 9.8},
                          kNoDeviation,
                          {"sqlite"}},
                    razor_600("rosbag2/razor_v9", {"sqlite"}), razor_600("rosbag2/razor_v9/razor_v9_0.db3", {"sqlite"}),
                    razor_600("rosbag2/razor_msg_zstd_split", {"sqlite", "zstd"}),
                    razor_600("rosbag2/razor_file_zstd", {"sqlite", "zstd"}),
                    razor_600("rosbag2/razor_zstd.mcap", {"zstd"}), razor_600("rosbag2/razor_lz4.mcap", {"lz4"}),
                    Known{"rosbag2/all_types.mcap",
                          "/test/sensor_msgs/imu",
                          2,
                          1749315324953324032,
                          1749315325013542912,
                          {0.01, 0.02, 0.03, 0.1, 0.2, 9.8},
                          kNoDeviation,
                          {"zstd", "lz4"}},
                    Known{"rosbag2/razor_nochunk.mcap",
                          "/imu/data_raw",
                          150,
                          kRazorFirst,
                          1352907617070817947,
                          {0.125534198, 0.984661139, -0.748931406, 1.87909792, 4.18909948, 3.55591406},
                          {2.14360, 8.26212, 1.58425, 6.59195, 3.95917, 5.76684}}),
    [](const auto& known) {
      std::string name = known.param.file;
      for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
      return name;
    });

void compare_first(const std::string& file, std::size_t all, std::size_t first, std::int64_t last_ns, const Six& mean,
                   const Six& deviation) {
  const auto recording = log::open_recording(real_log(file));
  EXPECT_CONTAINS(notes(*recording), "ends at byte " + std::to_string(std::filesystem::file_size(real_log(file))));
  log::Rows rows = read(*recording, stream(*recording, "/imu/data_raw"), kSixAxes);
  ASSERT_EQ(rows.stamps_ns.size(), all);
  EXPECT_EQ(rows.stamps_ns[first - 1], last_ns);
  for (std::size_t i = 0; i < 6; ++i) {
    rows.columns[i].resize(first);
    compare(rows.columns[i], mean[i], deviation[i]);
  }
}

/// 915 messages in whole chunks, and 79 in the one that is cut.
TEST(RealCutRecording, ABagKeepsWhatIsWhole) {
  SKIP_WITHOUT_LOGS();
  compare_first("ros1/razor_unindexed_cut.bag.active", 994, 915, 1352907628200346946,
                {0.21585854, 0.196851577, -0.0523952071, 0.109963542, 2.70884264, 3.97897814},
                {2.37323, 5.39794, 1.37447, 5.51125, 5.01367, 6.68373});
}

TEST(RealCutRecording, AnMcapKeepsWhatIsWhole) {
  SKIP_WITHOUT_LOGS();
  compare_first("rosbag2/razor_cut.mcap", 96, 75, 1352907615918005943,
                {-0.686718765, 1.79616943, -0.429595848, 3.34186875, 4.08808646, 2.59820833}, kNoDeviation);
}

TEST(RealRecordings, MagneticFields) {
  SKIP_WITHOUT_LOGS();
  if (packings({"lz4"}).empty()) GTEST_SKIP() << "a build without lz4";
  const auto recording = log::open_recording(real_log("ros1/razor_lz4.bag"));
  const std::size_t topic = stream(*recording, "/imu/mag");
  EXPECT_EQ(recording->streams()[topic].kind, log::StreamKind::magnetometer);
  const log::Rows rows = read(*recording, topic, {"magnetic_field.x", "magnetic_field.y", "magnetic_field.z"});
  ASSERT_EQ(rows.columns[0].size(), 2144U);
  const double mean[] = {1.8817041e-05, -3.16894881e-05, -6.52838672e-05};
  const double deviation[] = {3.59548e-05, 3.35855e-05, 4.42834e-05};
  for (std::size_t i = 0; i < 3; ++i) compare(rows.columns[i], mean[i], deviation[i]);
}

TEST(RealRecordings, CovariancesOfTheJackal) {
  SKIP_WITHOUT_LOGS();
  if (packings({"bz2"}).empty()) GTEST_SKIP() << "a build without bzip2";
  const auto recording = log::open_recording(real_log("ros1/jackal_sim_bz2.bag"));
  const log::Rows rows =
      read(*recording, stream(*recording, "/imu/data"),
           {"orientation_covariance[0]", "angular_velocity_covariance[0]", "linear_acceleration_covariance[0]"});
  EXPECT_NEAR(rows.columns[0].at(0), 2.6e-7, 0.06e-7);
  EXPECT_NEAR(rows.columns[1].at(0), 2.5e-5, 0.06e-5);
  EXPECT_NEAR(rows.columns[2].at(0), 2.5e-5, 0.06e-5);
}

TEST(RealRecordings, WithoutAnImuListWhatThereIs) {
  SKIP_WITHOUT_LOGS();
  if (packings({"lz4"}).empty()) GTEST_SKIP() << "a build without lz4";
  const auto turtle = log::open_recording(real_log("ros1/turtlesim_lz4.bag"));
  EXPECT_EQ(turtle->streams().size(), 9U);
  for (const log::StreamInfo& info : turtle->streams()) EXPECT_TRUE(info.fields.empty()) << info.name;
  EXPECT_TRUE(log::open_recording(real_log("ros1/no_messages.bag"))->streams().empty());
  EXPECT_EQ(log::open_recording(real_log("ros1/unsorted_chunks.bag"))->streams().at(0).count, 3);
  const auto split = log::open_recording(real_log("rosbag2/split_mcap"));
  EXPECT_EQ(split->streams().at(stream(*split, "/chatter")).count, 1324 + 1324 + 529);
  const log::Rows rows = split->read(stream(*split, "/chatter"), {});
  EXPECT_TRUE(std::is_sorted(rows.stamps_ns.begin(), rows.stamps_ns.end()));
  const auto talker = log::open_recording(real_log("rosbag2/talker.mcap"));
  EXPECT_EQ(talker->streams().at(stream(*talker, "/topic")).count, 10);
  EXPECT_EQ(talker->streams().at(stream(*talker, "/parameter_events")).count, 0);
}

}  // namespace
}  // namespace gyrobudget::app_tests
