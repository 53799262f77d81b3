// SPDX-License-Identifier: MIT
// Readers on inputs near those that people have: bytes flipped, cut, repeated, swapped, or replaced by words that mean
// something. The same inputs in every run; tests/fuzz also builds them as libFuzzer programs (preset fuzz).
#include "gyrobudget/app/log/recording.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <exception>
#include <random>
#include <string>
#include <string_view>

#include "entries.h"
#include "memory_file.h"

namespace gyrobudget::fuzz {
namespace {

constexpr int kMostChanges = 6;

constexpr std::array<std::string_view, 44> kWords = {"\n",
                                                     "\r\n",
                                                     "\n\n",
                                                     ",",
                                                     ";",
                                                     "\t",
                                                     " ",
                                                     "\"",
                                                     "#",
                                                     "%",
                                                     "//",
                                                     "(",
                                                     ")",
                                                     "[",
                                                     "]",
                                                     "(s)",
                                                     "(deg/s)",
                                                     "[ns]",
                                                     "time",
                                                     "gyro_x",
                                                     "nan",
                                                     "-inf",
                                                     "NA",
                                                     "1e999",
                                                     "1e-999",
                                                     "-0",
                                                     "+1",
                                                     "0.5",
                                                     "0,5",
                                                     "9223372036854775807",
                                                     "-9223372036854775808",
                                                     "18446744073709551616",
                                                     "1e18",
                                                     "0.1",
                                                     "1e5",
                                                     ".",
                                                     "-",
                                                     "e",
                                                     ":",
                                                     "{",
                                                     "&a",
                                                     "*a",
                                                     "sqrt(",
                                                     "\xc2\xb0"};

class Mutator {
 public:
  explicit Mutator(std::uint64_t seed) : engine_(seed) {}

  std::string mutant(const std::string& seed) {
    std::string text = seed;
    for (std::uint64_t n = 1 + below(kMostChanges); n > 0; --n) change(text);
    return text;
  }

 private:
  std::uint64_t below(std::uint64_t limit) { return limit == 0 ? 0 : engine_() % limit; }

  void change(std::string& text) {
    const std::size_t at = below(text.size() + 1), length = below(std::min<std::size_t>(text.size() - at, 40) + 1);
    switch (below(6)) {
      case 0:
        if (at < text.size()) text[at] = static_cast<char>(below(256));
        return;
      case 1:
        text.erase(at, length);
        return;
      case 2:
        text.insert(below(text.size() + 1), text.substr(at, length));
        return;
      case 3:
        text.insert(at, kWords[below(kWords.size())]);
        return;
      case 4:
        text.replace(at, std::min<std::size_t>(length, 4), kWords[below(kWords.size())]);
        return;
      default:
        text.resize(at);
    }
  }

  std::mt19937_64 engine_;
};

/// What left the entry that should not; empty for nothing.
std::string fault(const Entry& entry, const std::string& input) {
  try {
    entry.run(input);
    return {};
  } catch (const std::exception& error) {
    return error.what();
  } catch (...) {
    return "something that is no exception";
  }
}

class Mutations : public testing::TestWithParam<std::size_t> {};

TEST_P(Mutations, NothingButWhatIsDocumentedLeaves) {
  const Entry& entry = entries()[GetParam()];
  Mutator mutator(GetParam());
  for (const std::string& seed : entry.seeds) {
    ASSERT_EQ(fault(entry, seed), "") << entry.name << ": " << testing::PrintToString(seed);
    for (int i = 0; i < entry.mutants; ++i) {
      const std::string input = mutator.mutant(seed);
      ASSERT_EQ(fault(entry, input), "") << entry.name << ": " << testing::PrintToString(input);
    }
  }
}

TEST(Seeds, OfRecordingsAreRead) {
  for (const Entry& entry : recording_entries()) {
    for (const std::string& seed : entry.seeds) {
      const MemoryFile file(seed);
      const auto recording = log::open_recording(file.path());
      ASSERT_TRUE(recording) << entry.name;
      EXPECT_TRUE(std::ranges::any_of(recording->streams(), [](const log::StreamInfo& s) {
        return s.count > 1 && !s.fields.empty();
      })) << entry.name;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Readers, Mutations, testing::Range<std::size_t>(0, entries().size()),
                         [](const auto& entry) { return entries()[entry.param].name; });

}  // namespace
}  // namespace gyrobudget::fuzz
