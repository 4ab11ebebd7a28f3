// SPDX-License-Identifier: Apache-2.0
// A Site as one SQLite file (site.majak). Poses, constraints and figures are ordinary columns, so
// that any SQLite tool can ask; the rest of a scan is one blob. Versioned and checksummed: what is
// read is what was written, or an Error says that it is not. docs/FORMATS.md has the tables.
#pragma once

#include <filesystem>

#include "majak/core/site.hpp"

namespace majak::io {

/// Replaces the file as a whole: a kill at any moment leaves the old or the new one. Equal sites
/// give equal bytes. Throws Error (path, cause), for example on a full disk.
void write_site(const std::filesystem::path& path, const Site& site);

/// Throws Error (path, what is wrong) for a file that is missing, of another program, cut short,
/// damaged, or written by a newer version.
Site read_site(const std::filesystem::path& path);

}  // namespace majak::io
