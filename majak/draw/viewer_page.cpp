// SPDX-License-Identifier: Apache-2.0
#include "majak/draw/viewer_page.hpp"

#ifdef MAJAK_VIEWER_FOLDER

// The assembler reads the files: a compiler would take seconds for so long a literal.
#define MAJAK_CARRY(name, file)                                                           \
  asm(".pushsection .rodata\n.globl " name "_begin\n" name                                \
      "_begin:\n.incbin \"" MAJAK_VIEWER_FOLDER "/" file "\"\n.globl " name "_end\n" name \
      "_end:\n.byte 0\n.popsection\n")
MAJAK_CARRY("majak_viewer_html", "index.html");
MAJAK_CARRY("majak_viewer_script", "viewer.js");
MAJAK_CARRY("majak_viewer_style", "viewer.css");
#undef MAJAK_CARRY

extern "C" {
extern const char majak_viewer_html_begin[], majak_viewer_html_end[];
extern const char majak_viewer_script_begin[], majak_viewer_script_end[];
extern const char majak_viewer_style_begin[], majak_viewer_style_end[];
}

namespace majak::draw {
namespace {

std::string_view text(const char* begin, const char* end) {
  return {begin, static_cast<std::size_t>(end - begin)};
}

}  // namespace

ViewerPage viewer_page() {
  return {text(majak_viewer_html_begin, majak_viewer_html_end),
          text(majak_viewer_script_begin, majak_viewer_script_end),
          text(majak_viewer_style_begin, majak_viewer_style_end)};
}

}  // namespace majak::draw

#else

namespace majak::draw {

ViewerPage viewer_page() { return {}; }

}  // namespace majak::draw

#endif
