// SPDX-License-Identifier: MIT
// Inputs that are packed: text, raw numbers, .npy and recordings, by each library that the build has.
#include "gyrobudget/app/log/bytes.h"
#include "gyrobudget/app/log/log.h"
#include "gyrobudget/app/log/stream.h"

#include <gtest/gtest.h>

#if GYROBUDGET_HAS_BZIP2
#include <bzlib.h>
#endif
#if GYROBUDGET_HAS_LZ4
#include <lz4frame.h>
#endif
#if GYROBUDGET_HAS_ZSTD
#include <zstd.h>
#endif

#include <functional>

#include "../../packing.h"
#include "recorded.h"
#include "ulog_writer.h"

namespace gyrobudget::app_tests {
namespace {

using Compressed = RecordingTest;

struct Way {
  std::string name, ending, command;
  std::function<std::string(const std::string&)> pack;
};

const std::vector<Way>& ways() {
  static const std::vector<Way> kWays {
    {"gzip", ".gz", "zcat", [](const std::string& text) { return deflated(text, 15 + 16); }},
#if GYROBUDGET_HAS_BZIP2
        {"bzip2", ".bz2", "bzcat",
         [](const std::string& text) {
           auto size = static_cast<unsigned>(text.size() + text.size() / 50 + 1000);
           std::string result(size, '\0');
           BZ2_bzBuffToBuffCompress(result.data(), &size, const_cast<char*>(text.data()),
                                    static_cast<unsigned>(text.size()), 9, 0, 0);
           result.resize(size);
           return result;
         }},
#endif
#if GYROBUDGET_HAS_LZ4
        {"lz4", ".lz4", "lz4cat",
         [](const std::string& text) {
           LZ4F_preferences_t preferences = {};
           preferences.frameInfo.contentChecksumFlag = LZ4F_contentChecksumEnabled;
           std::string result(LZ4F_compressFrameBound(text.size(), &preferences), '\0');
           result.resize(LZ4F_compressFrame(result.data(), result.size(), text.data(), text.size(), &preferences));
           return result;
         }},
#endif
#if GYROBUDGET_HAS_ZSTD
        {"zstd", ".zst", "zstdcat", [](const std::string& text) {
           ZSTD_CCtx* context = ZSTD_createCCtx();
           ZSTD_CCtx_setParameter(context, ZSTD_c_checksumFlag, 1);
           std::string result(ZSTD_compressBound(text.size()), '\0');
           result.resize(ZSTD_compress2(context, result.data(), result.size(), text.data(), text.size()));
           ZSTD_freeCCtx(context);
           return result;
         }},
#endif
  };
  return kWays;
}

std::string text_log(int rows) {
  std::string text = "time (s),gyro_x (deg/s)\n";
  for (int i = 0; i < rows; ++i) text += std::to_string(i) + "," + std::to_string(i * i % 10007) + "\n";
  return text;
}

TEST_F(Compressed, TextInOneFrameInSeveralAndWithPadding) {
  const std::string text = text_log(3000), half = text.substr(0, 20000), rest = text.substr(20000);
  const allan::Record plain = log::read_log({.path = file("plain.csv", text)});
  for (const Way& way : ways()) {
    for (const std::string& bytes :
         {way.pack(text), way.pack(half) + way.pack(rest), way.pack(text) + std::string(512, '\0')}) {
      const allan::Record record = log::read_log({.path = file("packed", bytes)});
      EXPECT_EQ(record.axes[0].rate, plain.axes[0].rate) << way.name;
      expect_note(record.notes, way.name + " was unpacked into memory");
    }
  }
}

TEST_F(Compressed, RawNumbersAndNpyByTheNameBeforeTheEnding) {
  std::string numbers;
  for (int i = 0; i < 1000; ++i) numbers += packed(static_cast<double>(i * i % 97));
  const log::LogOptions options{.rate_hz = 10, .unit = "rad/s"};
  for (const Way& way : ways()) {
    log::LogOptions raw = options;
    raw.path = file("log.f64" + way.ending, way.pack(numbers));
    const allan::Record record = log::read_log(raw);
    EXPECT_EQ(record.samples, 1000) << way.name;
    EXPECT_EQ(record.axes[0].rate[10], 100 % 97);
    expect_note(record.notes, way.name + " was unpacked into memory");
    EXPECT_CONTAINS(message_of<text::InputError>([&] {
                      log::LogStream stream(raw);
                      std::vector<std::vector<double>> rates;
                      while (stream.read(rates, std::chrono::milliseconds(100)) != log::LogStream::Progress::end) {
                      }
                    }),
                    "is " + way.name + ", which is not read as a stream; unpack it: " + way.command);
    std::string header = "{'descr': '<f8', 'fortran_order': False, 'shape': (1000,), }";
    header.resize(117, ' ');
    header += '\n';
    raw.path = file("LOG.NPY" + way.ending, way.pack("\x93NUMPY" + std::string("\x01\0\x76\0", 4) + header + numbers));
    EXPECT_EQ(log::read_log(raw).axes[0].rate, record.axes[0].rate);
    EXPECT_EQ(log::open_recording(raw.path), nullptr);
  }
}

TEST_F(Compressed, DamageCutsAndWhatFollows) {
  const std::string text = text_log(30000);
  for (const Way& way : ways()) {
    const std::string whole = way.pack(text);
    const auto message = [&](const std::string& bytes) {
      const std::string path = file("packed", bytes);
      return message_of<text::InputError>([&] { (void)log::read_log({.path = path}); });
    };
    for (const std::size_t size : {std::size_t{14}, std::size_t{200}, whole.size() / 2, whole.size() - 1}) {
      EXPECT_CONTAINS(message(whole.substr(0, size)), "the " + way.name + " data stop in the middle, after ");
      EXPECT_CONTAINS(message(whole.substr(0, size)), way.command + " | head -n -1");
    }
    std::string damaged = whole;
    damaged[whole.size() - 3] ^= 0x10;
    damaged[whole.size() / 2] ^= 0x10;
    EXPECT_CONTAINS(message(damaged), "the " + way.name + " data are damaged after ");
    EXPECT_CONTAINS(message(whole + "something else"), "the " + way.name + " data end, but the file goes on");
  }
}

TEST_F(Compressed, GrowthHasACap) {
  const std::string zeros(std::size_t{80} << 20, '\0');
  for (const Way& way : ways()) {
    if (way.name == "gzip" || way.name == "lz4") continue;  // which cannot pack so well
    const std::string path = file("log.f64", way.pack(zeros));
    EXPECT_CONTAINS(
        message_of<text::InputError>([&] { (void)log::read_log({.path = path, .rate_hz = 1, .unit = "1"}); }),
        "unpacks to more than")
        << way.name;
  }
}

std::string ulog(int rows) {
  UlogWriter log;
  log.format("sensor_gyro:uint64_t timestamp;float x;float y;float z;").subscribe(0, "sensor_gyro");
  for (int i = 0; i < rows; ++i)
    log.data(0, packed(std::uint64_t(1000 * i), std::sin(i * i * 1.F), 2.F, std::cos(i * i * 3.F)));
  return log.bytes();
}

TEST_F(Compressed, RecordingsAreRecognisedWithin) {
  const std::string bytes = ulog(20000);
  const auto plain = open(bytes);
  for (const Way& way : ways()) {
    const std::string packed = way.pack(bytes);
    EXPECT_EQ(log::recorded_format(packed.substr(0, 512)), "");
    const auto recording = open(packed);
    EXPECT_EQ(recording->format(), "PX4 ULog") << way.name;
    EXPECT_EQ(read(*recording, "sensor_gyro", {"z"}).columns, read(*plain, "sensor_gyro", {"z"}).columns);
    EXPECT_EQ(log::open_recording(file("text", way.pack(text_log(3000)))), nullptr);
    cut_everywhere(way.pack(ulog(3000)));
    if (way.name == "bzip2") continue;  // one block, of which nothing comes out before its end
    const auto cut = open(packed.substr(0, packed.size() / 2));
    expect_note(cut->notes(), "the " + way.name + " data stop in the middle");
    EXPECT_GT(info(*cut, "sensor_gyro").count, 1000);
    EXPECT_LT(info(*cut, "sensor_gyro").count, 20000);
  }
}

TEST_F(Compressed, Hdf5AndMatlabWithin) {
  const std::string path = real("mat/imu_struct_v73.mat");
  SKIP_WITHOUT(path);
#if GYROBUDGET_HAS_HDF5
  const std::string bytes = content(path);
  for (const Way& way : ways()) {
    EXPECT_EQ(info(*open(way.pack(bytes)), "imu").count, 600) << way.name;
    const std::string half = way.pack(bytes).substr(0, 20000);
    if (way.name != "gzip") continue;  // nothing comes out of a block that is not whole
    EXPECT_CONTAINS(refusal(half), "stop in the middle");
  }
#endif
  for (const Way& way : ways())
    EXPECT_EQ(info(*open(way.pack(content(real("mat/imu_struct_v7.mat")))), "imu").count, 600);
}

TEST_F(Compressed, MarksThatAreNone) {
  EXPECT_EQ(log::compression_of("BZh9 is how this text begins"), log::Compression::none);
  EXPECT_EQ(log::compression_of("BZ"), log::Compression::none);
  EXPECT_EQ(log::compression_of("\x1f\x8b\x07"), log::Compression::none);
  EXPECT_EQ(log::compression_of(""), log::Compression::none);
  EXPECT_EQ(log::without_compression("log.npy.zst"), "log.npy");
  EXPECT_EQ(log::without_compression("log.db3.ZSTD"), "log.db3");
  EXPECT_EQ(log::without_compression("log.npy"), "log.npy");
}

#if !GYROBUDGET_HAS_ZSTD
TEST_F(Compressed, ALibraryThatIsMissingIsNamed) {
  EXPECT_CONTAINS(message_of<text::InputError>([&] {
                    (void)log::read_log({.path = file("log",
                                                      "\x28\xb5\x2f\xfd"
                                                      "1234")});
                  }),
                  "which this build cannot unpack; build it with Debian's package libzstd-dev");
}
#endif

}  // namespace
}  // namespace gyrobudget::app_tests
