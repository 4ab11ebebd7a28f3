// SPDX-License-Identifier: Apache-2.0
// The little of SQLite that the site file needs, with errors as exceptions.
#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "majak/core/error.hpp"

namespace majak::io {

class Database {
 public:
  /// A new database in memory.
  static Database in_memory();
  /// An existing file, never written to.
  static Database read_only(const std::string& path);

  void run(const char* sql) const;
  /// Hands out the bytes that the file of this database has, from first to last, in pieces.
  void serialize(const std::function<void(std::string_view)>& take) const;
  sqlite3* handle() const { return handle_.get(); }
  [[noreturn]] void fail() const { throw Error(sqlite3_errmsg(handle_.get())); }

 private:
  struct Close {
    void operator()(sqlite3* db) const { sqlite3_close(db); }
  };
  explicit Database(const std::string& name, int flags);
  std::unique_ptr<sqlite3, Close> handle_;
};

/// A prepared statement. Parameters are bound from left to right, columns read likewise.
class Statement {
 public:
  Statement(const Database& database, const char* sql) : database_(database) {
    sqlite3_stmt* raw = nullptr;
    if (sqlite3_prepare_v2(database.handle(), sql, -1, &raw, nullptr) != SQLITE_OK) database.fail();
    handle_.reset(raw);
  }

  Statement& bind(std::int64_t value) {
    return check(sqlite3_bind_int64(handle_.get(), ++column_, value));
  }
  Statement& bind(double value) {
    return check(sqlite3_bind_double(handle_.get(), ++column_, value + 0.0));
  }
  /// The text must live until run().
  Statement& bind_text(std::string_view text) {
    return check(sqlite3_bind_text64(handle_.get(), ++column_, text.data(), text.size(),
                                     SQLITE_STATIC, SQLITE_UTF8));
  }
  Statement& bind_blob(std::string_view bytes) {
    return check(
        sqlite3_bind_blob64(handle_.get(), ++column_, bytes.data(), bytes.size(), SQLITE_STATIC));
  }
  /// Executes and makes ready for the next row's values.
  void run() {
    step();
    rewind();
  }

  /// Back to before the first row, for new values.
  void rewind() {
    sqlite3_reset(handle_.get());
    column_ = 0;
  }
  /// Moves to the next row; false when there is none.
  bool step() {
    const int code = sqlite3_step(handle_.get());
    if (code != SQLITE_ROW && code != SQLITE_DONE) database_.fail();
    column_ = 0;
    return code == SQLITE_ROW;
  }
  std::int64_t integer() { return sqlite3_column_int64(handle_.get(), column_++); }
  double real();
  /// Text or blob; valid until the next step.
  std::string_view bytes();

 private:
  Statement& check(int code) {
    if (code != SQLITE_OK) database_.fail();
    return *this;
  }
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
  };
  const Database& database_;
  std::unique_ptr<sqlite3_stmt, Finalize> handle_;
  int column_ = 0;
};

}  // namespace majak::io
