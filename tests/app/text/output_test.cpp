// SPDX-License-Identifier: MIT
#include "gyrobudget/app/text/output.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <thread>

#include "../temporary.h"

namespace gyrobudget::app_tests {
namespace {

using text::OutputError;
using text::OutputFile;
namespace fs = std::filesystem;

class Output : public TemporaryFolder {};

TEST_F(Output, AppearsWholeAtCommitAndNotBefore) {
  OutputFile file(path("a.yaml"));
  file.write("one ");
  file.write("two");
  EXPECT_FALSE(fs::exists(path("a.yaml")));
  file.commit();
  EXPECT_EQ(content(path("a.yaml")), "one two");
  EXPECT_EQ(files(), 1U);
}

TEST_F(Output, LeavesNothingWithoutCommit) {
  {
    OutputFile file(path("a.yaml"));
    file.write("half");
    EXPECT_EQ(files(), 1U);  // the temporary, in the folder of the target
  }
  EXPECT_EQ(files(), 0U);
}

TEST_F(Output, KeepsTheOldFileUntilCommitAndItsRights) {
  const std::string target = file("a.yaml", "old");
  ASSERT_EQ(::chmod(target.c_str(), 0640), 0);
  {
    OutputFile abandoned(target);
    abandoned.write("new");
  }
  EXPECT_EQ(content(target), "old");
  text::write_file(target, "new");
  EXPECT_EQ(content(target), "new");
  struct stat status = {};
  ASSERT_EQ(::stat(target.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0640U);
}

TEST_F(Output, IsWrittenThroughLinks) {
  fs::create_directory(path("there"));
  const std::string link = path("link"), second = path("there/second");
  fs::create_symlink("there/second", link);  // beside the link, not beside us
  fs::create_symlink("file", second);
  for (const char* content_then : {"made", "replaced"}) {
    text::write_file(link, content_then);
    EXPECT_TRUE(fs::is_symlink(link) && fs::is_symlink(second));
    EXPECT_EQ(content(path("there/file")), content_then);
  }
  fs::create_symlink("nowhere/file", path("lost"));
  EXPECT_CONTAINS(message_of<OutputError>([&] { text::write_file(path("lost"), "x"); }), "create its folder first");
}

// What a killed run left goes; what another one writes, or is none of ours, stays.
TEST_F(Output, WhatKilledRunsLeftBehindGoes) {
  const OutputFile other(path("a.yaml"));  // its temporary is locked
  (void)file(".a.yaml.99999-1.part", "left behind");
  for (const char* name : {".a.yaml.part", ".a.yaml.x-1.part", ".b.yaml.99999-1.part", "a.yaml.99999-1.part"})
    (void)file(name, "not ours");
  EXPECT_EQ(files(), 6U);
  text::write_file(path("a.yaml"), "new");
  EXPECT_FALSE(fs::exists(path(".a.yaml.99999-1.part")));
  EXPECT_EQ(files(), 6U);  // less the one, and the new file
}

TEST_F(Output, HonoursTheUmask) {
  const mode_t before = ::umask(027);
  text::write_file(path("a"), "x");
  ::umask(before);
  struct stat status = {};
  ASSERT_EQ(::stat(path("a").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0640U);
}

TEST_F(Output, ReplacesWhatALinkPointsAt) {
  const std::string target = file("target", "old");
  fs::create_symlink(target, path("link"));
  text::write_file(path("link"), "new");
  EXPECT_TRUE(fs::is_symlink(path("link")));
  EXPECT_EQ(content(target), "new");
}

TEST_F(Output, WritesAPipeInPlace) {
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  std::string received;
  std::thread reader([&] { received = content(path("pipe")); });
  text::write_file(path("pipe"), "through");
  reader.join();
  EXPECT_EQ(received, "through");
  EXPECT_TRUE(fs::is_fifo(path("pipe")));
}

TEST_F(Output, DashIsStandardOutput) {
  testing::internal::CaptureStdout();
  text::write_file("-", "to stdout");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "to stdout");
}

TEST_F(Output, DevStdoutIsWrittenInPlaceEvenWhereItIsAFile) {
  testing::internal::CaptureStdout();  // redirects into a regular file, which must not be replaced
  text::write_file("/dev/stdout", "in place");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "in place");
}

TEST_F(Output, NamesPathReasonAndMend) {
  const auto message = [](const std::string& path) {
    return message_of<OutputError>([&] { text::write_file(path, "bytes"); });
  };
  EXPECT_EQ(message("/dev/full"),
            "/dev/full: cannot be written: No space left on device; free some space or choose another disk");
  EXPECT_EQ(message(path("no/such/a")),
            path("no/such/a") + ": cannot be written: No such file or directory; create its folder first");
  EXPECT_CONTAINS(message(path("")), "Is a directory; name a file in that folder");
  EXPECT_CONTAINS(message(file("plain", "") + "/a"), "Not a directory");
  EXPECT_CONTAINS(message(path(std::string(300, 'x'))), "File name too long; choose a shorter name");
  EXPECT_CONTAINS(message(""), "is empty");
}

TEST_F(Output, DoesNotReplaceAWriteProtectedFile) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may write everything";
  const std::string target = file("a", "old");
  ASSERT_EQ(::chmod(target.c_str(), 0444), 0);
  EXPECT_CONTAINS(message_of<OutputError>([&] { text::write_file(target, "new"); }), "choose a place you may write to");
  EXPECT_EQ(content(target), "old");
}

TEST_F(Output, AFullDiskLeavesTheOldFileAndNoPart) {
  // A file size limit stands in for a full disk: write() fails after the first block.
  const std::string target = file("a", "old");
  rlimit before = {};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit tight = {4096, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &tight), 0);
  const std::string message = message_of<OutputError>([&] { text::write_file(target, std::string(100000, 'x')); });
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
  EXPECT_CONTAINS(message, "File too large");
  EXPECT_EQ(content(target), "old");
  EXPECT_EQ(files(), 1U);
}

TEST_F(Output, AClosedPipeIsAnError) {
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const auto handler = std::signal(SIGPIPE, SIG_IGN);
  ::close(ends[0]);
  const std::string path = "/dev/fd/" + std::to_string(ends[1]);
  EXPECT_CONTAINS(message_of<OutputError>([&] { text::write_file(path, "x"); }), "Broken pipe; the program that reads");
  ::close(ends[1]);
  std::signal(SIGPIPE, handler);
}

TEST_F(Output, AnInterruptRemovesWhatWasNotCommitted) {
  const std::string kept = file("kept", "old");
  text::write_file(path("done"), "done");
  OutputFile first(path("first"));
  OutputFile second(kept);
  first.write("half");
  EXPECT_EQ(files(), 4U);
  text::remove_unfinished_outputs();
  EXPECT_EQ(files(), 2U);
  EXPECT_EQ(content(kept), "old");
  EXPECT_EQ(content(path("done")), "done");
}

TEST_F(Output, ManyInARowNeedNoMoreRoom) {
  for (int i = 0; i < 100; ++i) text::write_file(path("a"), std::to_string(i));
  EXPECT_EQ(content(path("a")), "99");
}

}  // namespace
}  // namespace gyrobudget::app_tests
