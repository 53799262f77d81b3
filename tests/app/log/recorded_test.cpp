// SPDX-License-Identifier: MIT
// From streams to columns: which stream, which of its fields, in what order of rows.
#include "gyrobudget/app/log/recorded.h"

#include "gyrobudget/app/text/error.h"
#include "gyrobudget/noise/constants.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace gyrobudget::log {
namespace {

using testing::DoubleEq;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pointwise;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A recording in memory.
class Recorder final : public Recording {
 public:
  struct Made {
    StreamInfo info;
    Rows rows;  ///< with all fields
  };
  explicit Recorder(std::vector<Made> made) : made_(std::move(made)) {
    for (const Made& m : made_) streams_.push_back(m.info);
  }
  [[nodiscard]] std::string format() const override { return "test recording"; }
  [[nodiscard]] const std::vector<StreamInfo>& streams() const override { return streams_; }
  [[nodiscard]] const std::vector<std::string>& notes() const override { return notes_; }
  [[nodiscard]] Rows read(std::size_t stream, std::span<const std::size_t> fields) const override {
    const Rows& all = made_.at(stream).rows;
    Rows rows{all.stamps_ns, all.clock, {}, all.notes};
    for (const std::size_t f : fields) rows.columns.push_back(all.columns.at(f));
    return rows;
  }

 private:
  std::vector<Made> made_;
  std::vector<StreamInfo> streams_;
  std::vector<std::string> notes_{"cut at byte 7"};
};

Recorder::Made imu(const std::string& name) {
  const StreamInfo info{.name = name,
                        .type = "Imu",
                        .kind = StreamKind::imu,
                        .fields = {{"orientation.w", "", ""},
                                   {"angular_velocity.x", "deg/s", "Imu"},
                                   {"linear_acceleration.z", "g", "Imu"},
                                   {"temperature", "degC", "Imu"},
                                   {"id", "", ""}},
                        .count = 4,
                        .clock = "header.stamp"};
  // The second and third are exchanged, and the last repeats the stamp before it.
  return {info,
          {.stamps_ns = {1'700'000'000'000'000'001, 1'700'000'000'020'000'001, 1'700'000'000'010'000'001,
                         1'700'000'000'020'000'001},
           .clock = "header.stamp",
           .columns = {{1, 1, 1, 1}, {10, 30, 20, 99}, {1, 2, kNaN, 99}, {25, 26, 27, 99}, {0, 1, 0, 1}},
           .notes = {"of the stream"}}};
}

Recorder::Made other(const std::string& name) {
  return {{.name = name, .type = "String", .count = 3, .clock = "record"}, {}};
}

TEST(Recorded, ReadsTheOnlyImuInTheUnitsOfItsFormatAndInOrder) {
  const Recorder recorder({other("/chatter"), imu("/imu")});
  const Recorded r = read_recorded(recorder, {.path = "walk.bag"});
  EXPECT_EQ(r.source, "walk.bag, /imu");
  EXPECT_THAT(r.choice.notes, ElementsAre(HasSubstr("is read as the temperature")));  // nothing of what is no rate
  ASSERT_EQ(r.choice.data.size(), 3U);                                                // and the temperature behind them
  EXPECT_EQ(r.choice.data[0].name, "angular_velocity.x");
  EXPECT_EQ(r.choice.data[1].signal, noise::Signal::specific_force);
  ASSERT_TRUE(r.choice.temperature);
  EXPECT_THAT(r.stamps, ElementsAre(1'700'000'000'000'000'001, 1'700'000'000'010'000'001, 1'700'000'000'020'000'001));
  constexpr double degree = std::numbers::pi / 180;
  EXPECT_THAT(r.numbers[0], Pointwise(DoubleEq(), {10 * degree, 20 * degree, 30 * degree}));
  EXPECT_EQ(r.numbers[1][0], noise::kStandardGravity);
  EXPECT_TRUE(std::isnan(r.numbers[1][1]));
  EXPECT_THAT(r.numbers[2], ElementsAre(25, 27, 26));
  EXPECT_THAT(r.notes, ElementsAre("cut at byte 7", "of the stream", HasSubstr("goes back 1 times"),
                                   HasSubstr("1 rows repeat a stamp")));
}

TEST(Recorded, OfSeveralNoneIsPicked) {
  const Recorder recorder({imu("/imu/data"), imu("/imu/raw"), other("/chatter")});
  try {
    (void)choose_stream(recorder, "walk.bag", {});
    FAIL() << "one was picked";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("/imu/data (imu, 4 rows) and /imu/raw (imu, 4 rows); choose one"));
  }
  EXPECT_EQ(choose_stream(recorder, "walk.bag", "/imu/raw"), 1U);
  EXPECT_THROW((void)choose_stream(recorder, "walk.bag", "/imu/rav"), std::invalid_argument);
  EXPECT_THROW((void)choose_stream(recorder, "walk.bag", "/chatter"), text::InputError);
}

TEST(Recorded, OneWithoutAnImuSaysWhatItHas) {
  const Recorder recorder({other("/chatter"), other("/rosout")});
  try {
    (void)choose_stream(recorder, "walk.bag", {});
    FAIL();
  } catch (const text::InputError& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("it has /chatter (String, 3 rows) and /rosout (String, 3 rows); cut at byte 7"));
  }
}

TEST(Recorded, ArraysHaveTheirTimeByNameAndTheirUnitFromTheUser) {
  const StreamInfo info{.name = "imu", .fields = {{"t", "", ""}, {"wb[0]", "", ""}, {"wb[1]", "", ""}}, .count = 3};
  const Recorder recorder({{info, {.columns = {{5, 5.01, 5.02}, {1, 2, 3}, {4, kNaN, 6}}}}});
  const Recorded r = read_recorded(recorder, {.path = "imu.mat", .rate_hz = 100, .unit = "rad/s"});
  EXPECT_THAT(r.stamps, ElementsAre(5'000'000'000, 5'010'000'000, 5'020'000'000));
  ASSERT_EQ(r.numbers.size(), 2U);
  EXPECT_THAT(r.numbers[0], ElementsAre(1, 2, 3));
  EXPECT_THROW((void)read_recorded(recorder, {.path = "imu.mat", .rate_hz = 100}), text::InputError);  // no unit
}

TEST(Recorded, ArraysCountOnlyWhereThereIsNoSensor) {
  const Recorder::Made arrays{{.name = "FMT", .fields = {{"Type", "", ""}}, .count = 3}, {}};
  EXPECT_THAT(sensor_streams(Recorder({arrays, imu("/imu")})), ElementsAre(1U));
  EXPECT_THAT(sensor_streams(Recorder({other("/chatter"), arrays})), ElementsAre(1U));
  EXPECT_THAT(sensor_streams(Recorder({other("/chatter")})), ElementsAre());
}

TEST(Recorded, RowsOfOneSensorAreChosenByAField) {
  const Recorder recorder({imu("/imu")});
  const Recorded r = read_recorded(recorder, {.path = "walk.bag", .rows = RowsOf{"id", 0}});
  ASSERT_TRUE(r.choice.rows_of);
  EXPECT_THAT(r.numbers.back(), ElementsAre(0, 0, 1));  // behind the temperature
}

}  // namespace
}  // namespace gyrobudget::log
