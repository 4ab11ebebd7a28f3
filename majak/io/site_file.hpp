// SPDX-License-Identifier: Apache-2.0
// A Site as one SQLite file (site.majak). Poses, constraints and figures are ordinary columns, so
// that any SQLite tool can ask; the rest of a scan is one blob. Versioned and checksummed: what is
// read is what was written, or an Error says that it is not. docs/FORMATS.md has the tables.
#pragma once

#include <cstdint>
#include <filesystem>

#include "majak/core/site.hpp"

namespace majak::io {

/// Replaces the file as a whole: a kill at any moment leaves the old or the new one. Equal sites
/// give equal bytes. Throws Error (path, cause), for example on a full disk, and for a site whose
/// edits are applied.
void write_site(const std::filesystem::path& path, const Site& site);

/// Keeps site.edits, and nothing else of the site, for the site file that is there, in a small file
/// beside it: on the disk when this returns, in milliseconds however large the site is. A kill at
/// any moment leaves the old edits or the new ones. The next write_site() takes that file away.
void write_edits(const std::filesystem::path& path, const Site& site);

/// The site as it is to be used: with its edits (map/edits), the newest ones. Throws Error (path,
/// what is wrong) for a file that is missing, of another program, cut short, damaged, or written by
/// a newer version.
Site read_site(const std::filesystem::path& path);

/// The site as it was kept, its edits beside it: for those who change them.
Site read_site_to_edit(const std::filesystem::path& path);

/// Where write_edits() keeps edits that are newer than the site file.
std::filesystem::path edits_file(const std::filesystem::path& site_file);

/// That the site file states of itself. Throws Error as read_site() does.
std::int64_t site_checksum(const std::filesystem::path& path);

}  // namespace majak::io
