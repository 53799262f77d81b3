// SPDX-License-Identifier: MIT
// Bags of ROS 2: databases of every layout, packed or not, split, with metadata or without.
#include "gyrobudget/app/log/formats/rosbag2.h"

#include "gyrobudget/app/log/recording.h"
#include "gyrobudget/app/text/error.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "../temporary.h"
#include "recording_fixture.h"
#include "recording_writer.h"

#if GYROBUDGET_HAS_SQLITE
#include <sqlite3.h>
#endif

namespace gyrobudget::app_tests {
namespace {

using namespace recording_writer;
using text::InputError;

TEST(Rosbag2Metadata, NamesItsFilesInEveryWayThatRecordersWrite) {
  const std::string root = "rosbag2_bagfile_information:\n";
  const std::vector<std::string> two{"a_0.db3", "a_1.db3"};
  for (const char* files :
       {"  relative_file_paths:\n    - a_0.db3\n    - a_1.db3\n  duration:\n    - 5\n",
        "  relative_file_paths:\n  - 'a_0.db3'\n  # a comment\n\n  - \"a_1.db3\"   # one\nother: 1\n",
        "  relative_file_paths: [a_0.db3, 'a_1.db3']\n", "  relative_file_paths: [a_0.db3,\n    a_1.db3]\r\n",
        "  version: 9\r\n  custom_data: ~\r\n  relative_file_paths:\r\n    - a_0.db3\r\n    - a_1.db3"}) {
    EXPECT_EQ(log::rosbag2_files(root + files), two) << files;
  }
  EXPECT_EQ(log::rosbag2_files(root + "  relative_file_paths:\n  - 'it''s'\n  - \"a \\\"b\\\"\"\n"),
            (std::vector<std::string>{"it's", "a \"b\""}));
  EXPECT_EQ(log::rosbag2_files(root + "  relative_file_paths: []\n"), std::vector<std::string>());
  EXPECT_EQ(log::rosbag2_files(root), std::vector<std::string>());
  EXPECT_EQ(log::rosbag2_files("relative_file_paths:\n- a\n"), std::nullopt);
  EXPECT_EQ(log::rosbag2_files(""), std::nullopt);
}

#if GYROBUDGET_HAS_SQLITE

std::string metadata(const std::vector<std::string>& files, int version = 5) {
  std::string text = "rosbag2_bagfile_information:\n  version: " + std::to_string(version) +
                     "\n  storage_identifier: sqlite3\n  relative_file_paths:\n";
  for (const std::string& file : files) text += "    - " + file + "\n";
  return text + "  message_count: 99\n";
}

std::string imu(int i) { return Cdr{}.imu(stamp_at(i), imu_numbers(i)); }

/// A database that rosbag2 would write.
class DatabaseWriter {
 public:
  explicit DatabaseWriter(const std::string& path, int layout = 4) {
    if (sqlite3_open(path.c_str(), &database_) != SQLITE_OK) throw std::runtime_error("no database");
    run("PRAGMA synchronous = OFF");
    std::string topics =
        "id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT NOT NULL";
    if (layout >= 2) topics += ", offered_qos_profiles TEXT NOT NULL DEFAULT ''";
    if (layout >= 4) topics += ", type_description_hash TEXT NOT NULL DEFAULT ''";
    run("CREATE TABLE topics(" + topics + ")");
    const std::string messages =
        "id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL";
    run("CREATE TABLE messages(" + messages + ")");
    run("CREATE INDEX timestamp_idx ON messages (timestamp ASC)");
    if (layout >= 3) {
      run("CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL)");
      run("CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL)");
    }
    if (layout >= 4) run("CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL)");
  }
  ~DatabaseWriter() { sqlite3_close(database_); }
  DatabaseWriter(const DatabaseWriter&) = delete;
  DatabaseWriter& operator=(const DatabaseWriter&) = delete;

  void run(const std::string& sql) {
    if (sqlite3_exec(database_, sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) {
      throw std::runtime_error(sqlite3_errmsg(database_));
    }
  }
  void topic(int id, const std::string& name, const std::string& type = "sensor_msgs/msg/Imu",
             const std::string& format = "cdr") {
    run("INSERT INTO topics(id, name, type, serialization_format) VALUES(" + std::to_string(id) + ", '" + name +
        "', '" + type + "', '" + format + "')");
  }
  void message(int topic, std::int64_t timestamp, const std::string& data) {
    sqlite3_stmt* insert = nullptr;
    sqlite3_prepare_v2(database_, "INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)", -1, &insert,
                       nullptr);
    sqlite3_bind_int(insert, 1, topic);
    sqlite3_bind_int64(insert, 2, timestamp);
    sqlite3_bind_blob(insert, 3, data.data(), static_cast<int>(data.size()), SQLITE_TRANSIENT);
    sqlite3_step(insert);
    sqlite3_finalize(insert);
  }
  /// Samples `first` to `last` of topic 1.
  void samples(int first, int last) {
    run("BEGIN");
    for (int i = first; i < last; ++i) message(1, ns(stamp_at(i, 500)), imu(i));
    run("COMMIT");
  }

 private:
  sqlite3* database_ = nullptr;
};

class Rosbag2 : public RecordingTest {
 protected:
  void folder(const std::string& name) const { std::filesystem::create_directories(path(name)); }
  void samples(const std::string& name, int first, int last, int layout = 4) const {
    DatabaseWriter database(path(name), layout);
    database.topic(1, "/imu");
    database.samples(first, last);
  }
  [[nodiscard]] std::unique_ptr<log::Recording> open(const std::string& name) const {
    auto recording = log::open_recording(path(name));
    if (!recording) throw std::runtime_error("not recognised");
    return recording;
  }
  [[nodiscard]] std::string refused(const std::string& name) const {
    return message_of<InputError>([&] { static_cast<void>(open(name)); });
  }
};

TEST_F(Rosbag2, DatabasesOfEveryLayoutByThemselves) {
  for (int layout = 1; layout <= 4; ++layout) {
    const std::string name = "layout" + std::to_string(layout) + ".bin";
    samples(name, 0, 20, layout);
    const auto recording = open(name);
    EXPECT_EQ(recording->format(), "rosbag2");
    ASSERT_EQ(recording->streams().size(), 1U);
    EXPECT_EQ(recording->streams()[0].count, 20);
    EXPECT_EQ(notes(*recording), "");
    expect_samples(*recording, 0, 0, 20);
  }
}

TEST_F(Rosbag2, TopicsWithoutMessagesAndOfOtherFormats) {
  {
    DatabaseWriter database(path("a.db3"));
    database.topic(7, "/empty");
    database.topic(1, "/imu");
    database.topic(2, "/other", "sensor_msgs/msg/Imu", "fake_format");
    database.topic(3, "/imu");  // once more, as after a restart
    database.samples(0, 3);
    database.message(3, 5, imu(3));
    database.message(2, 77, "x");
    database.message(99, 77, "x");
  }
  const auto recording = open("a.db3");
  ASSERT_EQ(recording->streams().size(), 3U);
  EXPECT_EQ(recording->streams()[stream(*recording, "/empty")].count, 0);
  EXPECT_TRUE(read(*recording, stream(*recording, "/empty"), kGyroX).stamps_ns.empty());
  EXPECT_TRUE(recording->streams()[stream(*recording, "/other")].fields.empty());
  EXPECT_EQ(recording->read(stream(*recording, "/other"), {}).stamps_ns, std::vector<std::int64_t>{77});
  EXPECT_CONTAINS(notes(*recording), "1 messages are left out: their topics are not declared");
  expect_samples(*recording, stream(*recording, "/imu"), 0, 4);
}

TEST_F(Rosbag2, RowsAreInTheOrderOfArrival) {
  {
    DatabaseWriter database(path("a.db3"));
    database.topic(1, "/imu");
    for (const int i : {2, 0, 1}) database.message(1, ns(stamp_at(i)), imu(i));
  }
  EXPECT_EQ(open("a.db3")->read(0, {}).stamps_ns,
            (std::vector<std::int64_t>{ns(stamp_at(2)), ns(stamp_at(0)), ns(stamp_at(1))}));
}

TEST_F(Rosbag2, FoldersBySortedNumberWhereMetadataAreMissing) {
  folder("bag");
  for (int part = 0; part < 12; ++part) samples("bag/run_" + std::to_string(part) + ".db3", 5 * part, 5 * part + 5);
  const auto recording = open("bag/");
  EXPECT_EQ(recording->streams().at(0).count, 60);
  EXPECT_CONTAINS(notes(*recording), "metadata.yaml");
  expect_samples(*recording, 0, 0, 60);
}

TEST_F(Rosbag2, FoldersByTheirMetadata) {
  folder("bag");
  samples("bag/b.db3", 0, 5);
  samples("bag/a.db3", 5, 9);
  samples("bag/stray.db3", 100, 105);
  static_cast<void>(file("bag/metadata.yaml", metadata({"b.db3", "a.db3"})));
  auto recording = open("bag");
  EXPECT_EQ(notes(*recording), "");
  expect_samples(*recording, 0, 0, 9);
  // Version 3 and older begin with the name of the folder, which may have another by now.
  for (const char* name : {"bag/", "as_recorded/"}) {
    static_cast<void>(
        file("bag/metadata.yaml", metadata({std::string(name) + "b.db3", std::string(name) + "a.db3"}, 2)));
    expect_samples(*open("bag"), 0, 0, 9);
  }
  static_cast<void>(file("bag/metadata.yaml", metadata({"b.db3", "gone.db3"})));
  recording = open("bag");
  EXPECT_CONTAINS(notes(*recording), "metadata.yaml names 'gone.db3', which is not there");
  expect_samples(*recording, 0, 0, 5);
}

TEST_F(Rosbag2, FoldersThatAreNoBagOrSeveral) {
  folder("empty");
  EXPECT_EQ(log::open_recording(path("empty")), nullptr);
  static_cast<void>(file("empty/metadata.yaml", "something: else\n"));
  EXPECT_EQ(log::open_recording(path("empty")), nullptr);
  folder("mixed");
  samples("mixed/a_0.db3", 0, 2);
  samples("mixed/b_0.db3", 0, 2);
  EXPECT_CONTAINS(refused("mixed"), "files of several recordings");
}

TEST_F(Rosbag2, AFileThatAKilledRecorderLeftEmptyCostsOnlyItself) {
  folder("bag");
  samples("bag/run_0.db3", 0, 5);
  static_cast<void>(file("bag/run_1.db3", ""));
  const auto recording = open("bag");
  EXPECT_CONTAINS(notes(*recording), "a file is left out: ");
  expect_samples(*recording, 0, 0, 5);
}

TEST_F(Rosbag2, WhatEndsOneFileAndBeginsTheNextIsReadOnce) {
  folder("bag");
  samples("bag/run_0.db3", 0, 5);
  samples("bag/run_1.db3", 4, 9);
  expect_samples(*open("bag"), 0, 0, 9, "1 messages are left out: they end one file and begin the next");
}

TEST_F(Rosbag2, McapInFoldersWhereIdsMeanOtherTopicsInEachFile) {
  folder("bag");
  for (int part = 0; part < 2; ++part) {
    McapWriter mcap;
    const unsigned imu_id = part == 0 ? 1 : 2;
    mcap.declare(mcap_schema(1, "sensor_msgs/msg/Imu"));
    mcap.declare(mcap_channel(imu_id, 1, "/imu", "cdr"));
    mcap.declare(mcap_channel(3 - imu_id, 1, "/other", "cdr"));
    for (int i = 3 * part; i < 3 * part + 3; ++i) {
      mcap.message(imu_id, static_cast<std::uint64_t>(ns(stamp_at(i))), imu(i));
      mcap.message(3 - imu_id, static_cast<std::uint64_t>(ns(stamp_at(i))), imu(i + 50));
    }
    mcap.end_chunk();
    static_cast<void>(file("bag/run_" + std::to_string(part) + ".mcap", mcap.closed()));
  }
  const auto recording = open("bag");
  EXPECT_EQ(recording->format(), "rosbag2");
  expect_samples(*recording, stream(*recording, "/imu"), 0, 6);
  expect_samples(*recording, stream(*recording, "/other"), 50, 56);
}

TEST_F(Rosbag2, PackedFilesAndPackedMessages) {
  if (packings({"zstd"}).empty()) GTEST_SKIP() << "a build without zstd";
  folder("bag");
  samples("plain", 0, 10);
  const std::string packed = pack("zstd", content(path("plain")));
  static_cast<void>(file("bag/run_0.db3.zstd", packed));
  static_cast<void>(file("bag/metadata.yaml", metadata({"run_0.db3.zstd"})));
  expect_samples(*open("bag"), 0, 0, 10);
  static_cast<void>(file("bag/metadata.yaml", metadata({"run_0.db3"})));
  expect_samples(*open("bag"), 0, 0, 10);
  expect_samples(*open("bag/run_0.db3.zstd"), 0, 0, 10);
  {
    DatabaseWriter database(path("messages.db3"));
    database.topic(1, "/imu");
    for (int i = 0; i < 5; ++i) database.message(1, 5, pack("zstd", imu(i)));
    database.message(1, 5, pack("zstd", imu(0)).substr(0, 60));
  }
  expect_samples(*open("messages.db3"), 0, 0, 5,
                 "1 messages are left out: they have not the length of sensor_msgs/Imu");
  EXPECT_EQ(log::open_recording(file("text.zst", pack("zstd", "some text"))), nullptr);
}

/// A recorder that works with a journal of what is to come, and was killed.
TEST_F(Rosbag2, MessagesThatOnlyTheJournalHas) {
  {
    DatabaseWriter database(path("live.db3"));
    database.run("PRAGMA journal_mode = WAL");
    database.run("PRAGMA wal_autocheckpoint = 0");
    database.topic(1, "/imu");
    database.samples(0, 7);
    std::filesystem::copy_file(path("live.db3"), path("killed.db3"));
    std::filesystem::copy_file(path("live.db3-wal"), path("killed.db3-wal"));
  }
  const std::string before = content(path("killed.db3")), journal = content(path("killed.db3-wal"));
  const std::size_t files_before = files();
  const auto recording = open("killed.db3");
  EXPECT_CONTAINS(notes(*recording), "its recorder left -wal beside it");
  expect_samples(*recording, 0, 0, 7);
  EXPECT_EQ(files(), files_before);  // and nothing is changed
  EXPECT_EQ(content(path("killed.db3")), before);
  EXPECT_EQ(content(path("killed.db3-wal")), journal);
  // Closed in order, the database still says that it works with a journal; one that is empty means nothing.
  expect_samples(*open("live.db3"), 0, 0, 7);
  static_cast<void>(file("live.db3-wal", ""));
  static_cast<void>(file("live.db3-shm", std::string(32768, 'x')));
  const auto closed = open("live.db3");
  EXPECT_EQ(notes(*closed), "");
  expect_samples(*closed, 0, 0, 7);
}

TEST_F(Rosbag2, NamesThatAreOptionsToSqlite) {
  samples("a?mode=rw#b%41.db3", 0, 3);
  expect_samples(*open("a?mode=rw#b%41.db3"), 0, 0, 3);
}

TEST_F(Rosbag2, OtherDatabasesAreRefused) {
  {
    DatabaseWriter database(path("views.db3"));
    database.run("ALTER TABLE messages RENAME TO m");
    database.run(
        "CREATE VIEW messages AS WITH RECURSIVE r(n) AS (SELECT 1 UNION ALL SELECT n + 1 FROM r) SELECT n AS id, 1 AS topic_id, n AS timestamp, n AS data FROM r");
  }
  EXPECT_CONTAINS(refused("views.db3"),
                  "without messages.topic_id, expected the tables topics and messages of rosbag2");
  {
    DatabaseWriter database(path("columns.db3"));
    database.run("ALTER TABLE messages RENAME COLUMN data TO content");
  }
  EXPECT_CONTAINS(refused("columns.db3"), "without messages.data");
  EXPECT_CONTAINS(refusal(std::string("SQLite format 3\0", 16) + std::string(4000, 'x')),
                  "it is no database of rosbag2");
}

TEST_F(Rosbag2, CutAtEveryHundredth) {
  samples("whole.db3", 0, 200);
  const std::string whole = content(path("whole.db3"));
  std::size_t opened_ones = 0, most = 0;
  for (std::size_t hundredth = 1; hundredth < 100; ++hundredth) {
    try {
      const auto recording = opened(whole.substr(0, whole.size() * hundredth / 100));
      ++opened_ones;
      const bool is_there = !recording->streams().empty() && !recording->streams()[0].fields.empty();
      const std::size_t rows = is_there ? read(*recording, 0, kGyroX).stamps_ns.size() : 0;
      EXPECT_CONTAINS(notes(*recording), "the database is cut");
      most = std::max(most, rows);
    } catch (const InputError& error) {
      EXPECT_CONTAINS(std::string(error.what()), "; ");
    }
  }
  EXPECT_GT(opened_ones, 50U);
  EXPECT_GT(most, 190U);
}

TEST_F(Rosbag2, TwoThreadsReadTwoStreams) {
  {
    DatabaseWriter database(path("a.db3"));
    database.topic(1, "/imu");
    database.topic(2, "/imu2");
    for (int i = 0; i < 500; ++i) {
      database.message(1, 5, imu(i));
      database.message(2, 5, imu(i + 1));
    }
  }
  const auto recording = open("a.db3");
  std::thread other([&] { expect_samples(*recording, 0, 0, 500); });
  expect_samples(*recording, 1, 1, 501);
  other.join();
}

#else

using Rosbag2 = RecordingTest;

TEST_F(Rosbag2, ABuildWithoutSqliteNamesThePackage) {
  EXPECT_CONTAINS(refusal(std::string("SQLite format 3\0", 16)), "libsqlite3-dev");
}

#endif

}  // namespace
}  // namespace gyrobudget::app_tests
