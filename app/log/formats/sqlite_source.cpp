// SPDX-License-Identifier: MIT
#include "sqlite_source.h"

#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>

#include "temporary_folder.h"

#if GYROBUDGET_HAS_SQLITE
#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <optional>
#include <unordered_map>
#include <utility>
#endif

namespace gyrobudget::inline v0::log {

#if GYROBUDGET_HAS_SQLITE
namespace {

struct CloseDatabase {
  void operator()(sqlite3* database) const { sqlite3_close_v2(database); }
};
using Database = std::unique_ptr<sqlite3, CloseDatabase>;

[[noreturn]] void fail_sqlite(const std::string& name, std::string_view what, sqlite3* database) {
  text::fail(name, fmt::format("{}: {}; it is no database of rosbag2, or damaged: try sqlite3 FILE .recover", what,
                               text::quoted(database ? sqlite3_errmsg(database) : "no memory")));
}

/// A query, row by row.
class Query {
 public:
  /// @throws text::InputError where the database does not understand it.
  Query(const std::string& name, const Database& database, const std::string& sql) {
    sqlite3_stmt* statement = nullptr;
    const int status = sqlite3_prepare_v2(database.get(), sql.c_str(), -1, &statement, nullptr);
    statement_.reset(statement);
    if (status != SQLITE_OK) fail_sqlite(name, "cannot be asked for its messages", database.get());
  }
  bool next() {
    status_ = sqlite3_step(statement_.get());
    return status_ == SQLITE_ROW;
  }
  /// Why there is no next row; empty where all have come.
  [[nodiscard]] std::string fault() const {
    return status_ == SQLITE_DONE || status_ == SQLITE_ROW ? std::string() : sqlite3_errstr(status_);
  }
  [[nodiscard]] std::int64_t integer(int column) const { return sqlite3_column_int64(statement_.get(), column); }
  /// A text or the bytes of a blob, valid until the next row.
  [[nodiscard]] std::string_view bytes(int column) const {
    const auto* data = static_cast<const char*>(sqlite3_column_blob(statement_.get(), column));
    const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column));
    return data ? std::string_view(data, size) : std::string_view();
  }

 private:
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
  };
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
  int status_ = SQLITE_OK;
};

/// The path as a URI, absolute, in which nothing is an option.
std::string sqlite_uri(const std::string& path) {
  std::string uri = "file:";
  for (const char c : std::filesystem::absolute(path).lexically_normal().string()) {
    if (c == '%' || c == '?' || c == '#') {
      uri += fmt::format("%{:02x}", static_cast<unsigned char>(c));
    } else {
      uri += c;
    }
  }
  return uri;
}

Database open_database(const std::string& name, const std::string& uri, int flags) {
  sqlite3* opened = nullptr;
  const int status = sqlite3_open_v2(uri.c_str(), &opened, flags | SQLITE_OPEN_URI | SQLITE_OPEN_FULLMUTEX, nullptr);
  Database database(opened);
  if (status != SQLITE_OK) fail_sqlite(name, "cannot be opened", opened);
  // A stranger wrote its schema: nothing there may call functions.
  sqlite3_db_config(opened, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  return database;
}

/// Nothing is locked, and nothing written: the file is as it is.
Database open_unchanging(const std::string& name, const std::string& path) {
  Database database = open_database(name, sqlite_uri(path) + "?immutable=1", SQLITE_OPEN_READONLY);
  // SQLite gives what is left of a database that was cut only to those who say that they would mend it.
  sqlite3_exec(database.get(), "PRAGMA writable_schema = ON", nullptr, nullptr, nullptr);
  return database;
}

/// Bytes that a database has by its header; 0 where that does not tell.
std::uint64_t bytes_of_header(const std::string& path) {
  constexpr std::size_t kHeader = 100, kPageSize = 16, kChanges = 24, kPages = 28, kChangesOfPages = 92;
  std::array<unsigned char, kHeader> header{};
  std::ifstream file(path, std::ios::binary);
  file.read(reinterpret_cast<char*>(header.data()), kHeader);
  const auto big_endian = [&](std::size_t at, std::size_t size) {
    std::uint64_t value = 0;
    for (std::size_t i = at; i < at + size; ++i) value = value << 8U | header[i];
    return value;
  };
  const std::uint64_t page = big_endian(kPageSize, 2) == 1 ? 65536 : big_endian(kPageSize, 2);
  const bool is_told = file && big_endian(kChanges, 4) == big_endian(kChangesOfPages, 4);
  return is_told ? page * big_endian(kPages, 4) : 0;
}

class SqliteSource : public MessageSource {
 public:
  SqliteSource(const std::string& path, const std::string& name) : name_(name) {
    open(path);
    check_tables();
    find_topics();
    count_messages();
  }

  [[nodiscard]] const std::string& name() const override { return name_; }
  [[nodiscard]] std::uint64_t bytes() const override { return bytes_; }
  [[nodiscard]] const std::vector<Topic>& topics() const override { return topics_; }
  [[nodiscard]] const Findings& findings() const override { return findings_; }
  std::int64_t visit(const std::vector<bool>& wanted, MessageSink& sink, Findings& findings) const override;

 private:
  void open(const std::string& path);
  void apply_journals(const std::string& path, const std::vector<std::string>& journals);
  void check_tables();
  [[nodiscard]] bool has_column(const std::string& table, std::string_view column) const;
  void find_topics();
  void count_messages();
  [[nodiscard]] std::string order() const { return has_column("messages", "id") ? " ORDER BY id" : ""; }
  void tell_damage(const Query& query, std::int64_t messages, Findings& findings) const;

  std::string name_;
  std::uint64_t bytes_ = 0;
  Database database_;
  std::vector<Topic> topics_;
  std::unordered_map<std::int64_t, std::size_t> topic_of_;
  Findings findings_;
};

void SqliteSource::open(const std::string& path) {
  std::error_code error;
  std::vector<std::string> journals;
  for (const char* suffix : {"-wal", "-journal"}) {
    const auto size = std::filesystem::file_size(path + suffix, error);
    if (!error && size > 0) journals.emplace_back(suffix);
  }
  bytes_ = std::filesystem::file_size(path, error);
  const std::uint64_t whole = bytes_of_header(path);
  if (journals.empty() && bytes_ < whole) {
    findings_.add(
        fmt::format("the database is cut: it ends at byte {} of {}, and its last message may be torn", bytes_, whole));
  }
  if (journals.empty()) {
    database_ = open_unchanging(name_, path);
  } else {
    apply_journals(path, journals);
  }
}

/// Messages may stand in the journal alone. To open the file itself would write to the user's folder.
void SqliteSource::apply_journals(const std::string& path, const std::vector<std::string>& journals) {
  const TemporaryFolder folder(name_);
  const std::string copy = folder.path("copy.db3");
  folder.copy(path, "copy.db3");
  for (const std::string& suffix : journals) folder.copy(path + suffix, "copy.db3" + suffix);
  {
    const Database database = open_database(name_, sqlite_uri(copy), SQLITE_OPEN_READWRITE);
    Query applied(name_, database, "SELECT count(*) FROM sqlite_master");
    while (applied.next()) continue;
    sqlite3_wal_checkpoint_v2(database.get(), nullptr, SQLITE_CHECKPOINT_TRUNCATE, nullptr, nullptr);
  }
  findings_.add(fmt::format("its recorder left {} beside it, whose messages are read too", text::listing(journals)));
  std::error_code error;
  bytes_ = std::max<std::uint64_t>(bytes_, std::filesystem::file_size(copy, error));
  database_ = open_unchanging(name_, copy);
  Query opens_it(name_, database_, "SELECT count(*) FROM sqlite_master");  // now, before the folder goes
  while (opens_it.next()) continue;
}

bool SqliteSource::has_column(const std::string& table, std::string_view column) const {
  Query query(name_, database_, fmt::format("PRAGMA table_info({})", table));
  bool found = false;
  while (query.next()) found = query.bytes(1) == column || found;
  return found;
}

/// Views and virtual tables, which run code, are no tables here.
void SqliteSource::check_tables() {
  Query query(name_, database_, "SELECT name FROM sqlite_master WHERE type = 'table' AND rootpage > 0");
  std::vector<std::string> tables;
  while (query.next()) tables.emplace_back(query.bytes(0));
  if (!query.fault().empty()) fail_sqlite(name_, "has no readable list of tables", database_.get());
  constexpr std::pair<const char*, const char*> kColumns[] = {{"topics", "id"},          {"topics", "name"},
                                                              {"topics", "type"},        {"messages", "topic_id"},
                                                              {"messages", "timestamp"}, {"messages", "data"}};
  for (const auto& [table, column] : kColumns) {
    if (std::ranges::find(tables, table) != tables.end() && has_column(table, column)) continue;
    text::fail(
        name_,
        fmt::format(
            "is an SQLite database without {}.{}, expected the tables topics and messages of rosbag2; name a bag, or export its numbers as text",
            table, column));
  }
}

void SqliteSource::find_topics() {
  const bool has_format = has_column("topics", "serialization_format");
  Query query(
      name_, database_,
      fmt::format("SELECT id, name, type, {} FROM topics ORDER BY id", has_format ? "serialization_format" : "'cdr'"));
  while (query.next()) {
    if (!topic_of_.try_emplace(query.integer(0), topics_.size()).second) continue;
    topics_.push_back({std::string(query.bytes(1)), std::string(query.bytes(2)),
                       query.bytes(3) == "cdr" ? Encoding::cdr : Encoding::other});
  }
  tell_damage(query, 0, findings_);
}

/// metadata.yaml has counts, which need not be true.
void SqliteSource::count_messages() {
  Query query(name_, database_, "SELECT topic_id FROM messages");
  std::int64_t messages = 0, unknown = 0;
  while (query.next()) {
    ++messages;
    const auto at = topic_of_.find(query.integer(0));
    if (at == topic_of_.end()) {
      ++unknown;
    } else {
      ++topics_[at->second].count;
    }
  }
  if (unknown > 0) {
    findings_.add(fmt::format("{} messages are left out: their topics are not declared", text::count_text(unknown)));
  }
  tell_damage(query, messages, findings_);
}

std::int64_t SqliteSource::visit(const std::vector<bool>& wanted, MessageSink& sink, Findings& findings) const {
  std::vector<std::string> ids;
  for (const auto& [id, topic] : topic_of_) {
    if (wanted[topic]) ids.push_back(fmt::format("{}", id));
  }
  constexpr std::size_t kMostIds = 1000;  // beyond them all messages are looked at
  const std::string where = ids.size() > kMostIds ? "" : fmt::format(" WHERE topic_id IN ({})", fmt::join(ids, ","));
  Query query(name_, database_, "SELECT topic_id, timestamp, data FROM messages" + where + order());
  std::int64_t messages = 0;
  while (query.next()) {
    const auto at = topic_of_.find(query.integer(0));
    if (at == topic_of_.end() || !wanted[at->second]) continue;
    ++messages;
    sink.take({at->second, query.integer(1), query.bytes(2)});
  }
  tell_damage(query, messages, findings);
  return messages;
}

void SqliteSource::tell_damage(const Query& query, std::int64_t messages, Findings& findings) const {
  const std::string fault = query.fault();
  if (fault.empty()) return;
  findings.add(fmt::format("the database is cut or damaged ({}): {} messages before the damage are kept", fault,
                           text::count_text(messages)));
}

}  // namespace
#endif

bool is_sqlite(std::string_view head) {
  constexpr std::string_view kMagic{"SQLite format 3\0", 16};
  return head.starts_with(kMagic);
}

std::unique_ptr<MessageSource> open_sqlite_source([[maybe_unused]] const std::string& path, const std::string& name) {
#if GYROBUDGET_HAS_SQLITE
  return std::make_unique<SqliteSource>(path, name);
#else
  text::fail(name,
             "is an SQLite database, which this build leaves out; install Debian's libsqlite3-dev and build again");
#endif
}

}  // namespace gyrobudget::inline v0::log
