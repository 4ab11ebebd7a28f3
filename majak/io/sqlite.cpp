// SPDX-License-Identifier: Apache-2.0
#include "majak/io/sqlite.hpp"

#include <algorithm>
#include <limits>

namespace majak::io {

Database::Database(const std::string& name, int flags) {
  sqlite3* raw = nullptr;
  const int code = sqlite3_open_v2(name.c_str(), &raw, flags, nullptr);
  handle_.reset(raw);
  if (code != SQLITE_OK) throw Error(raw ? sqlite3_errmsg(raw) : "not enough memory");
}

Database Database::in_memory() {
  return Database(":memory:", SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX);
}

Database Database::read_only(const std::string& path) {
  // Immutable: no locks, and no journal beside the file is believed.
  std::string uri = "file:";
  for (const char c : path) {
    if (c == '%' || c == '?' || c == '#') {
      constexpr const char* kHex = "0123456789abcdef";
      uri += {'%', kHex[(c >> 4) & 15], kHex[c & 15]};
    } else {
      uri += c;
    }
  }
  Database database(uri + "?immutable=1",
                    SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX);
  // The file may come from anywhere: its schema is data and nothing in it is executed.
  sqlite3_db_config(database.handle(), SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(database.handle(), SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  database.run("PRAGMA cell_size_check=ON");
  return database;
}

void Database::run(const char* sql) const {
  if (sqlite3_exec(handle_.get(), sql, nullptr, nullptr, nullptr) != SQLITE_OK) fail();
}

void Database::serialize(const std::function<void(std::string_view)>& take) const {
  constexpr std::size_t kPiece = 1 << 16;
  sqlite3_int64 size = 0;
  const std::unique_ptr<unsigned char, void (*)(void*)> bytes(
      sqlite3_serialize(handle_.get(), "main", &size, 0), sqlite3_free);
  if (!bytes) throw Error("not enough memory");
  std::string_view rest(reinterpret_cast<const char*>(bytes.get()), static_cast<std::size_t>(size));
  for (; !rest.empty(); rest.remove_prefix(std::min(kPiece, rest.size())))
    take(rest.substr(0, kPiece));
}

double Statement::real() {
  const int column = column_++;
  // SQLite keeps not-a-numbers as NULL.
  if (sqlite3_column_type(handle_.get(), column) == SQLITE_NULL)
    return std::numeric_limits<double>::quiet_NaN();
  return sqlite3_column_double(handle_.get(), column);
}

std::string_view Statement::bytes() {
  const int column = column_++;
  const void* data = sqlite3_column_blob(handle_.get(), column);
  return {static_cast<const char*>(data),
          static_cast<std::size_t>(sqlite3_column_bytes(handle_.get(), column))};
}

}  // namespace majak::io
