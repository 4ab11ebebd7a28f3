// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include "majak/io/atomic_file.hpp"
#include "majak/io/ros2_sqlite.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace {

/// A small bag as SQLite writes it.
std::string whole_bag() {
  using namespace majak::io;
  const Database database = Database::in_memory();
  database.run(
      "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format "
      "TEXT);"
      "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data "
      "BLOB);"
      "CREATE INDEX by_time ON messages(timestamp);"
      "INSERT INTO topics VALUES(1,'/scan','sensor_msgs/msg/LaserScan','cdr');"
      "INSERT INTO messages VALUES(1,1,10,x'00010000'),(2,1,20,zeroblob(3000)),(3,2,5,'x');");
  std::string bytes;
  database.serialize([&](std::string_view more) { bytes += more; });
  return bytes;
}

}  // namespace

/// A whole file with some bytes changed: each three bytes of input say where (16 bits) and to what.
MAJAK_FUZZ(patches) {
  static const std::string path = "/dev/shm/majak-fuzz-" + std::to_string(::getpid()) + ".db3";
  static const std::string whole = whole_bag();
  std::string bytes = whole;
  for (std::size_t i = 0; i + 2 < patches.size(); i += 3) {
    const auto low = static_cast<unsigned char>(patches[i]);
    const auto high = static_cast<unsigned char>(patches[i + 1]);
    bytes[(low + 256U * high) % bytes.size()] = patches[i + 2];
  }
  majak::io::write_file_atomically(path, bytes);
  majak::io::Ros2Sqlite log(path);
  majak::io::Message message;
  std::size_t rows = 0;
  while (log.next(message) && ++rows < 100000) log.topics().at(message.topic);
}
