// SPDX-License-Identifier: MIT
// What GNSS receivers and their tools write as text: RTKLIB's .pos, NMEA 0183, gpsd's JSON.
#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "recorded.h"

namespace gyrobudget::app_tests {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::NanSensitiveDoubleEq;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// 2025-08-28 17:30:39.749, from 1970; Thursday of week 2381, of which 4 days and 63039.749 s have passed.
constexpr std::int64_t kFirst = 1'756'402'239'749'000'000;

class GnssText : public TemporaryFolder {
 protected:
  [[nodiscard]] std::unique_ptr<log::Recording> open(const std::string& text) const {
    return log::open_recording(file("walk.txt", text));  // by its content alone
  }
  /// A field of the only stream.
  static std::vector<double> column(const log::Recording& recording, const std::string& name) {
    const auto& fields = recording.streams().at(0).fields;
    const auto at = std::ranges::find(fields, name, &log::Field::name);
    if (at == fields.end()) {
      ADD_FAILURE() << "no field " << name;
      return {};
    }
    const std::size_t place[] = {static_cast<std::size_t>(at - fields.begin())};
    return recording.read(0, place).columns.at(0);
  }
  static std::vector<std::int64_t> stamps(const log::Recording& recording) { return recording.read(0, {}).stamps_ns; }
  static std::string notes(const log::Recording& recording) {
    std::string all;
    for (const std::string& note : recording.notes()) all += note + "\n";
    for (const std::string& note : recording.read(0, {}).notes) all += note + "\n";
    return all;
  }
};

// --- RTKLIB ---------------------------------------------------------------------------------------------------------

const std::string kEllipsoidal =
    "% program   : RTKPOST ver.2.4.3\n% (lat/lon/height=WGS84/ellipsoidal,Q=1:fix,2:float,5:single,ns=# of satellites)\n";
const std::string kPlaces =
    "%  GPST  latitude(deg) longitude(deg)  height(m)   Q  ns   sdn(m)   sde(m)   sdu(m)  sdne(m)  sdeu(m)  sdun(m) age(s)  ratio    vn(m/s)    ve(m/s)    vu(m/s)\n";
const std::string kTail = " 40.1 -105.15 1600.5 1 18 0.02 0.03 0.04 -0.01 0 0 0.5 12.0 -1.5 1.25 -0.25\n";

TEST_F(GnssText, RtklibsPlacesVelocitiesAndSigmas) {
  const auto pos = open(kEllipsoidal + kPlaces + "2025/08/28 17:30:39.749" + kTail);
  ASSERT_TRUE(pos);
  EXPECT_EQ(pos->format(), "RTKLIB solution");
  EXPECT_EQ(pos->streams().at(0).clock, "GPST");
  EXPECT_EQ(pos->streams().at(0).kind, log::StreamKind::gnss);
  EXPECT_THAT(stamps(*pos), ElementsAre(kFirst));
  EXPECT_THAT(column(*pos, "longitude"), ElementsAre(-105.15));
  EXPECT_THAT(column(*pos, "height"), ElementsAre(1600.5));
  EXPECT_THAT(column(*pos, "quality"), ElementsAre(1));
  EXPECT_THAT(column(*pos, "position_sigma_north"), ElementsAre(0.02));
  EXPECT_THAT(column(*pos, "position_sigma_east"), ElementsAre(0.03));
  EXPECT_THAT(column(*pos, "velocity_up"), ElementsAre(-0.25));
  EXPECT_THAT(notes(*pos), IsEmpty());
}

TEST_F(GnssText, RtklibsWeekAndSecondsCommasAndHeadersSaidTwice) {
  std::string row = "2381,408639.749" + kTail;
  std::ranges::replace(row, ' ', ',');
  const auto pos = open(kEllipsoidal + kPlaces + row + kPlaces + "2025/08/28 17:30:39.999" + kTail);
  EXPECT_THAT(stamps(*pos), ElementsAre(kFirst, kFirst + 250'000'000));
}

TEST_F(GnssText, RtklibsHeightsAreSaidOrTakenAsItsDefault) {
  EXPECT_THAT(notes(*open(kPlaces + "2025/08/28 17:30:39.749" + kTail)), HasSubstr("taken as ellipsoidal"));
  const auto geodetic =
      open("% (lat/lon/height=WGS84/geodetic,Q=1:fix)\n" + kPlaces + "2025/08/28 17:30:39.749" + kTail);
  EXPECT_THAT(column(*geodetic, "height_over_geoid"), ElementsAre(1600.5));
  EXPECT_THAT(notes(*geodetic), IsEmpty());
}

TEST_F(GnssText, RtklibsDegreesMinutesAndSecondsWithTheirSign) {
  const auto pos = open(
      "%  UTC  latitude(d'\") longitude(d'\") height(m) Q ns\n"
      "2025/08/28 17:30:39.749 -00 30 36.0 105 09 00.0 12.5 5 7\n");
  EXPECT_EQ(pos->streams().at(0).clock, "UTC");
  EXPECT_THAT(column(*pos, "latitude"), ElementsAre(testing::DoubleEq(-0.51)));
  EXPECT_THAT(column(*pos, "longitude"), ElementsAre(testing::DoubleEq(105.15)));
}

TEST_F(GnssText, RtklibsEarthFixedAndBaselines) {
  const auto ecef = open(
      "%  GPST x-ecef(m) y-ecef(m) z-ecef(m) Q ns sdx(m) sdy(m) sdz(m) sdxy(m) sdyz(m) sdzx(m)\n"
      "2025/08/28 17:30:39.749 1.5 2.5 3.5 2 9 0.1 0.2 0.0 -0.1 0 0\n");
  EXPECT_THAT(column(*ecef, "ecef_z"), ElementsAre(3.5));
  EXPECT_THAT(column(*ecef, "position_sigma_xy"), ElementsAre(-0.1));
  EXPECT_THAT(column(*ecef, "position_sigma_z"), ElementsAre(NanSensitiveDoubleEq(kNaN)));  // 0 is none
  const auto base = open(
      "% ref pos   :  40.1 -105.15  1600.5\n%  GPST e-baseline(m) n-baseline(m) u-baseline(m) Q ns\n"
      "2025/08/28 17:30:39.749 1.5 2.5 3.5 2 9\n");
  EXPECT_THAT(column(*base, "baseline_north"), ElementsAre(2.5));
  EXPECT_THAT(column(*base, "base_longitude"), ElementsAre(-105.15));
  const auto alone =
      open("%  GPST e-baseline(m) n-baseline(m) u-baseline(m) Q ns\n2025/08/28 17:30:39.749 1 2 3 2 9\n");
  EXPECT_EQ(alone->streams().at(0).fields.size(), 5U);  // and no base
}

TEST_F(GnssText, RtklibsRowsThatAreNoneAreSaid) {
  const auto pos = open(kEllipsoidal + kPlaces + "2025/08/28 17:30:39.749" + kTail + "2025/08/28 17:30:39.9\n" +
                        "2025/08/28 17:30:4x.249" + kTail);
  EXPECT_EQ(pos->streams().at(0).count, 1);
  EXPECT_THAT(notes(*pos), HasSubstr("2 lines are left out, the first of them line 5"));
  EXPECT_THAT(message_of<text::InputError>([&] { (void)open(kPlaces + "2025/08/28 17:30:39.9 1 2\n"); }),
              HasSubstr("walk.txt:2:1: found no row of the 16 columns"));
  EXPECT_THAT(
      message_of<text::InputError>([&] { (void)open(kPlaces + "%  UTC  latitude(deg) longitude(deg) height(m) Q\n"); }),
      HasSubstr("walk.txt:2:1: found a second header"));
}

TEST_F(GnssText, OtherCommentsWithPercentAreNoSolution) {
  EXPECT_FALSE(open("% time (s), gyro_x (deg/s)\n0,1\n1,2\n"));
}

// --- NMEA -----------------------------------------------------------------------------------------------------------

std::string sentence(const std::string& content) {
  unsigned sum = 0;
  for (const char c : content) sum ^= static_cast<unsigned char>(c);
  return fmt::format("${}*{:02X}\r\n", content, sum);
}
std::string gga(const std::string& time,
                const std::string& rest = "4005.80123,N,10508.82999,W,4,12,0.8,1618.4,M,-16.9,M,,") {
  return sentence("GNGGA," + time + "," + rest);
}

TEST_F(GnssText, NmeasPlacesHeightsMotionAndErrors) {
  const auto nmea =
      open(gga("173039.75") + sentence("GNRMC,173039.75,A,4005.80123,N,10508.82999,W,7.2,90.0,280825,,,A") +
           sentence("GNGST,173039.75,1,2,3,4,0.5,0.6,0.7"));
  ASSERT_TRUE(nmea);
  EXPECT_EQ(nmea->format(), "NMEA 0183");
  EXPECT_THAT(stamps(*nmea), ElementsAre(kFirst + 1'000'000));
  EXPECT_THAT(column(*nmea, "latitude"), ElementsAre(testing::DoubleEq(40 + 5.80123 / 60)));
  EXPECT_THAT(column(*nmea, "longitude"), ElementsAre(testing::DoubleEq(-105 - 8.82999 / 60)));
  EXPECT_THAT(column(*nmea, "height_over_geoid"), ElementsAre(1618.4));
  EXPECT_THAT(column(*nmea, "geoid_height"), ElementsAre(-16.9));
  EXPECT_THAT(column(*nmea, "quality"), ElementsAre(4));
  EXPECT_THAT(column(*nmea, "speed"), ElementsAre(testing::DoubleEq(7.2 * 1852 / 3600)));
  EXPECT_THAT(column(*nmea, "course"), ElementsAre(90));
  EXPECT_THAT(column(*nmea, "position_sigma_east"), ElementsAre(0.6));
}

TEST_F(GnssText, NmeasDaysRollOverAndAreCountedBack) {
  const auto nmea = open(gga("235958.00") + gga("235959.00") + gga("000000.00") +
                         sentence("GNRMC,000000.00,A,4005.8,N,10508.8,W,1,2,290825,,,A") + gga("000001.00"));
  constexpr std::int64_t kMidnight = 1'756'425'600'000'000'000, kSecond = 1'000'000'000;  // before 2025-08-29
  EXPECT_THAT(stamps(*nmea), ElementsAre(kMidnight - 2 * kSecond, kMidnight - kSecond, kMidnight, kMidnight + kSecond));
  const auto undated = open(gga("235959.00") + gga("000000.50"));
  EXPECT_EQ(stamps(*undated)[1] - stamps(*undated)[0], kSecond * 3 / 2);
  EXPECT_THAT(notes(*undated), HasSubstr("no sentence tells the date"));
}

TEST_F(GnssText, NmeasDatesAreTakenAsRecorded) {
  const auto date = [&](const std::string& ddmmyy) {
    return stamps(*open(sentence("GPRMC,000000,A,4005.8,N,10508.8,W,1,2," + ddmmyy + ",,")))[0] / 86'400'000'000'000;
  };
  EXPECT_EQ(date("010711"), 15'156);  // 2011-07-01, which gpsd 3.22 moves by 1024 weeks
  EXPECT_EQ(date("060180"), 3'657);   // the first day of GPS
}

TEST_F(GnssText, NmeasReceiverThatStandsHasNoCourse) {
  const auto nmea =
      open(sentence("GPRMC,000000,A,4005.8,N,10508.8,W,0.0,123.4,010711,,") +
           sentence("GPRMC,000001,A,4005.8,N,10508.8,W,0.0,,010711,,") + sentence("GPRMC,000002,V,,,,,,,010711,,"));
  EXPECT_THAT(column(*nmea, "course"), testing::Each(NanSensitiveDoubleEq(kNaN)));
  EXPECT_THAT(column(*nmea, "quality"), ElementsAre(1, 1, 0));
}

TEST_F(GnssText, NmeasWrongSumsAndEmptySeparations) {
  const std::string right = gga("173039.75");
  std::string wrong = gga("173040.75");
  wrong[10] = '9';
  const auto nmea = open(right + wrong + gga("173041.75", "4005.8,N,10508.8,W,1,12,0.8,1618.4,M,,M,,") +
                         "$GPGGA,173042.75,no sum\r\n");
  EXPECT_EQ(nmea->streams().at(0).count, 2);
  EXPECT_THAT(notes(*nmea), HasSubstr("2 sentences are left out"));
  EXPECT_THAT(column(*nmea, "geoid_height"), ElementsAre(-16.9, NanSensitiveDoubleEq(kNaN)));
  EXPECT_FALSE(open("$VNIMU,+1,+2,+3,+1,+2,+3,+1,+2,+3,+31.4,+98.7*60\r\n"));
}

// --- gpsd -----------------------------------------------------------------------------------------------------------

TEST_F(GnssText, GpsdsReports) {
  const auto gpsd = open(
      "{\"class\":\"VERSION\",\"release\":\"3.22\"}\n"
      "{\"class\":\"TPV\",\"device\":\"/dev/a\",\"mode\":1}\n"
      "{\"class\":\"TPV\",\"device\":\"/dev/a\",\"mode\":3,\"time\":\"2025-08-28T17:30:39.749Z\",\"lat\":40.1,\"lon\":-105.15,\"altHAE\":1600.5,\"altMSL\":1617.4,\"alt\":1617.4,\"track\":90.5,\"magtrack\":82.1,\"speed\":2.5,\"climb\":-0.1,\"epx\":3,\"epy\":4,\"epv\":9,\"eps\":0.3}\n"
      "{\"class\":\"TPV\",\"device\":\"/dev/a\",\"mode\":3,\"time\":\"2025-08-28T17:30:40.749Z\",\"alt\":1617.5,\"track\":90.5,\"speed\":0}\n"
      "{\"class\":\"SKY\"}\n{\"class\":\"TPV\",\"dev");
  ASSERT_TRUE(gpsd);
  EXPECT_THAT(stamps(*gpsd), ElementsAre(kFirst, kFirst + 1'000'000'000));
  EXPECT_THAT(column(*gpsd, "height"), ElementsAre(1600.5, NanSensitiveDoubleEq(kNaN)));
  EXPECT_THAT(column(*gpsd, "height_over_geoid"), ElementsAre(1617.4, 1617.5));  // of old versions: alt
  EXPECT_THAT(column(*gpsd, "course"), ElementsAre(90.5, NanSensitiveDoubleEq(kNaN)));
  EXPECT_THAT(column(*gpsd, "position_sigma_north")[0], 4);
  EXPECT_THAT(notes(*gpsd), HasSubstr("1 lines are left out: they are no whole JSON object"));
  EXPECT_THAT(notes(*gpsd), HasSubstr("1 reports are left out: they have no time"));
  EXPECT_THAT(notes(*gpsd), HasSubstr("coarse table"));
  EXPECT_FALSE(open("{\"ts\":1709629801123,\"gx\":0.11}\n{\"ts\":1709629801133,\"gx\":0.11}\n"));
}

TEST_F(GnssText, GpsdsDevicesAreStreams) {
  const std::string report = ",\"mode\":3,\"time\":\"2025-08-28T17:30:39.749Z\"}\n";
  const auto gpsd =
      open("{\"class\":\"TPV\",\"device\":\"/dev/a\"" + report + "{\"class\":\"TPV\",\"device\":\"/dev/b\"" + report);
  ASSERT_EQ(gpsd->streams().size(), 2U);
  EXPECT_EQ(gpsd->streams()[1].name, "TPV /dev/b");
}

}  // namespace
}  // namespace gyrobudget::app_tests
