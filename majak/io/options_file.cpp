// SPDX-License-Identifier: Apache-2.0
#include "majak/io/options_file.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <limits>
#include <sstream>
#include <vector>

#include "majak/core/error.hpp"

namespace majak::io {

namespace {

using Value = std::variant<bool, int, double>;

/// The shortest text that reads back to the same double, marked as a TOML float.
std::string float_text(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  char buffer[40];
  std::string text(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

std::string value_text(const OptionField& field) {
  if (const auto* flag = std::get_if<bool*>(&field.value)) return **flag ? "true" : "false";
  if (const auto* number = std::get_if<int*>(&field.value)) return std::to_string(**number);
  return float_text(*std::get<double*>(field.value));
}

std::string bound_text(double bound) {
  if (std::isinf(bound)) return "any";
  return fmt::format("{}", bound);
}

bool has_range(const OptionField& field) {
  const bool bounded = std::isfinite(field.info.min) || std::isfinite(field.info.max);
  return bounded && !std::holds_alternative<bool*>(field.value);
}

std::string comment(const OptionField& field) {
  std::string text = "# ";
  text += field.info.help;
  std::string_view unit = field.info.unit;
  if (unit == "1") unit = {};
  const bool range = has_range(field);
  if (!unit.empty() || range) {
    text += unit.empty() ? " (" : fmt::format(" ({}", unit);
    if (!unit.empty() && range) text += ", ";
    if (range)
      text += fmt::format("{} ... {}", bound_text(field.info.min), bound_text(field.info.max));
    text += ')';
  }
  return text;
}

std::pair<std::string, std::string> split_name(const std::string& name) {
  const std::size_t dot = name.rfind('.');
  if (dot == std::string::npos) return {"", name};
  return {name.substr(0, dot), name.substr(dot + 1)};
}

const char* type_name(const OptionField& field) {
  if (std::holds_alternative<bool*>(field.value)) return "true or false";
  return std::holds_alternative<int*>(field.value) ? "a whole number" : "a number";
}

[[noreturn]] void fail(const std::string& where, const std::string& name, const std::string& what) {
  throw Error(fmt::format("{}: option {} {}", where, name, what));
}

Value checked(const OptionField& field, const toml::node& node, const std::string& where) {
  const auto check = [&](double number) {
    if (number >= field.info.min && number <= field.info.max) return;
    fail(where, field.name,
         fmt::format("is {}, but must be from {} to {}{}{}", number, bound_text(field.info.min),
                     bound_text(field.info.max), *field.info.unit ? " " : "",
                     std::string_view(field.info.unit) == "1" ? "" : field.info.unit));
  };
  if (std::holds_alternative<bool*>(field.value)) {
    if (const auto* flag = node.as_boolean()) return flag->get();
  } else if (const auto* whole = node.as_integer()) {
    const std::int64_t number = whole->get();
    check(static_cast<double>(number));
    if (std::holds_alternative<double*>(field.value)) return static_cast<double>(number);
    if (number == static_cast<int>(number)) return static_cast<int>(number);
  } else if (const auto* real = node.as_floating_point();
             real && std::holds_alternative<double*>(field.value)) {
    check(real->get());
    return real->get();
  }
  fail(where, field.name, fmt::format("must be {}", type_name(field)));
}

/// "did you mean" for the message: the same last part in another table, or nothing.
std::string hint(const OptionFields& fields, const std::string& name) {
  const std::string key = split_name(name).second;
  for (const OptionField& field : fields.list) {
    if (split_name(field.name).second == key) return fmt::format("; there is {}", field.name);
  }
  return "; options.toml of any run lists all";
}

struct Assignment {
  const OptionField* field;
  Value value;
};

void collect(const OptionFields& fields, const toml::table& table, const std::string& prefix,
             const std::string& file, std::vector<Assignment>& out) {
  for (const auto& [key, node] : table) {
    const std::string name = prefix + std::string(key.str());
    if (const auto* inner = node.as_table()) {
      collect(fields, *inner, name + '.', file, out);
      continue;
    }
    const std::string where = fmt::format("{}:{}", file, key.source().begin.line);
    const auto field = std::find_if(fields.list.begin(), fields.list.end(),
                                    [&](const OptionField& f) { return f.name == name; });
    if (field == fields.list.end()) fail(where, name, "is unknown" + hint(fields, name));
    out.push_back({&*field, checked(*field, node, where)});
  }
}

void assign(const Assignment& assignment) {
  std::visit(
      [](auto* target, auto value) {
        if constexpr (std::is_same_v<std::remove_pointer_t<decltype(target)>, decltype(value)>)
          *target = value;
      },
      assignment.field->value, assignment.value);
}

/// toml++ 3.3 runs into an unreachable point at U+FB26 ... U+FEFE (presentation forms of letters);
/// no option needs such a letter. U+FEFF, the mark at the start of a file, is fine.
void refuse_presentation_forms(std::string_view text, const std::string& name) {
  std::int64_t line = 1;
  for (std::size_t i = 0; i + 2 < text.size(); ++i) {
    if (text[i] == '\n') ++line;
    const auto second = static_cast<unsigned char>(text[i + 1]);
    if (text[i] != '\xEF' || second < 0xAC || second > 0xBB) continue;
    if (text.substr(i, 3) == "\xEF\xBB\xBF") continue;
    throw Error(
        fmt::format("{}:{}: not valid TOML: a letter outside all option names", name, line));
  }
}

}  // namespace

std::string options_toml(const OptionFields& fields) {
  std::vector<std::string> tables = {""};  // keys without a table must come first
  for (const OptionField& field : fields.list) {
    const std::string table = split_name(field.name).first;
    if (std::find(tables.begin(), tables.end(), table) == tables.end()) tables.push_back(table);
  }
  std::string text;
  for (const std::string& table : tables) {
    if (!table.empty()) text += fmt::format("{}[{}]\n", text.empty() ? "" : "\n", table);
    for (const OptionField& field : fields.list) {
      const auto [its_table, key] = split_name(field.name);
      if (its_table == table)
        text += fmt::format("{}\n{} = {}\n", comment(field), key, value_text(field));
    }
  }
  return text;
}

void apply_options(OptionFields& fields, std::string_view text, const std::string& name) {
  refuse_presentation_forms(text, name);
  std::vector<Assignment> assignments;
  try {
    const toml::table table = toml::parse(text, name);
    collect(fields, table, "", name, assignments);
  } catch (const toml::parse_error& e) {
    throw Error(
        fmt::format("{}:{}: not valid TOML: {}", name, e.source().begin.line, e.description()));
  }
  for (const Assignment& assignment : assignments) assign(assignment);
}

void apply_options_file(OptionFields& fields, const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  if (in) text << in.rdbuf();
  if (!in || !text)
    throw Error(path.string() + ": cannot be read; give a file written as options.toml");
  apply_options(fields, text.str(), path.string());
}

void apply_option(OptionFields& fields, std::string_view assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string_view::npos || assignment.find('\n') != std::string_view::npos) {
    throw Error(fmt::format("option \"{}\": write it as table.key=value", assignment));
  }
  apply_options(fields, assignment, "command line");
}

}  // namespace majak::io
