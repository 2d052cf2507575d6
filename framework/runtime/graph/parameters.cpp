#include "runtime/graph/parameters.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "runtime/plugins/programs.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

std::string shortest(double value) {
  char buffer[40];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value == 0 ? 0.0 : value).ptr};
}

template <typename Number>
std::optional<Number> parse(const std::string& text) {
  Number value{};
  const char* first = text.data() + (text.size() > 1 && text[0] == '+' ? 1 : 0);
  const auto [end, error] = std::from_chars(first, text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::string bounds_text(const plumbline_param& param) {
  const std::string unit = *param.unit && param.unit != std::string("1") ? std::string(" ") + param.unit : "";
  if (std::isfinite(param.minimum) && std::isfinite(param.maximum))
    return "between " + shortest(param.minimum) + " and " + shortest(param.maximum) + unit;
  return std::isfinite(param.minimum) ? "at least " + shortest(param.minimum) + unit
                                      : "at most " + shortest(param.maximum) + unit;
}

/// One value. Returns the canonical text, or nothing after it has told what is wrong.
class Checker {
 public:
  Checker(const plumbline_param& param, const std::string& owner, std::vector<Problem>& problems)
      : param_(param), name_("parameter '" + std::string(param.name) + "' of " + owner), problems_(problems) {}

  std::string check(const Scalar& value) {
    if (value.unresolved) return "";
    if (is_default(value)) return value.text;
    switch (param_.kind) {
      case PLUMBLINE_NUMBER:
        return number(value);
      case PLUMBLINE_INTEGER:
        return integer(value);
      case PLUMBLINE_BOOLEAN:
        if (value.text != "true" && value.text != "false") refuse(value, "true or false");
        return value.text;
      case PLUMBLINE_FILE:
        return path(value, false);
      case PLUMBLINE_FOLDER:
        return path(value, true);
      default:
        return text(value);
    }
  }

 private:
  /// A default may be what nobody can give in another way (nan: not known); a variable has to have it.
  bool is_default(const Scalar& value) const {
    return param_.kind == PLUMBLINE_NUMBER && !param_.is_list && param_.default_text &&
           value.text == param_.default_text;
  }

  void refuse(const Scalar& value, const std::string& expected) {
    tell(value, " takes " + expected + ", found '" + value.text + "'");
  }

  /// Where the value was given, which may be a variable; of all parameters that are given that one the first is named.
  void tell(const Scalar& value, const std::string& refusal) {
    if (value.given_at.file.empty()) return problems_.push_back({value.at, name_ + refusal});
    for (Problem& known : problems_)
      if (known.refusal == refusal && known.at.text() == value.given_at.text()) {
        ++known.alike;
        return;
      }
    problems_.push_back({value.given_at, name_ + refusal, 0, refusal});
  }

  std::string number(const Scalar& value) {
    const auto parsed = parse<double>(value.text);
    if (!parsed || !std::isfinite(*parsed)) {
      refuse(value, *param_.unit ? std::string("a number in ") + param_.unit : "a number");
      return "";
    }
    if (*parsed < param_.minimum || *parsed > param_.maximum) refuse(value, bounds_text(param_));
    return shortest(*parsed);
  }

  std::string integer(const Scalar& value) {
    const auto parsed = parse<int64_t>(value.text);
    if (!parsed) {
      refuse(value, "a whole number");
      return "";
    }
    if (static_cast<double>(*parsed) < param_.minimum || static_cast<double>(*parsed) > param_.maximum)
      refuse(value, bounds_text(param_));
    return std::to_string(*parsed);
  }

  std::string text(const Scalar& value) {
    if (!param_.choice_count) return value.text;
    const std::vector<std::string> choices(param_.choices, param_.choices + param_.choice_count);
    if (std::find(choices.begin(), choices.end(), value.text) != choices.end()) return value.text;
    std::string list;
    for (const std::string& choice : choices) list += (list.empty() ? "" : ", ") + choice;
    const auto near = near_names(value.text, choices);
    tell(value, " takes one of " + list + "; found '" + value.text + "'" +
                    (near.empty() ? "" : " — did you mean '" + near[0] + "'?"));
    return value.text;
  }

  std::string path(const Scalar& value, bool folder) {
    if (value.text.empty()) {  // "no file", where it need not be given
      if (!param_.default_text) refuse(value, folder ? "a folder" : "a file");
      return "";
    }
    if (names_program(param_) && value.text.find('/') == std::string::npos) {
      const std::string program = find_program(value.text);
      if (program == value.text) refuse(value, "a program on PATH, or the path of one");
      return program;
    }
    const fs::path full = fs::absolute(value.base / value.text).lexically_normal();
    std::error_code failed;
    if (!fs::exists(full, failed))
      tell(value, std::string(": there is no ") + (folder ? "folder " : "file ") + full.string());
    else if (fs::is_directory(full, failed) != folder)
      tell(value, std::string(" takes a ") + (folder ? "folder" : "file") + ", but " + full.string() + " is a " +
                      (folder ? "file" : "folder"));
    return full.string();
  }

  const plumbline_param& param_;
  std::string name_;
  std::vector<Problem>& problems_;
};

}  // namespace

std::map<std::string, std::string> check_parameters(const Kind& kind, const NodeSpec& node,
                                                    std::vector<Problem>& problems) {
  const std::string owner = "'" + std::string(kind.node->kind) + "'";
  std::map<std::string, std::string> result;
  std::vector<std::string> names;
  for (uint32_t i = 0; i < kind.node->param_count; ++i) {
    const plumbline_param& param = *kind.node->params[i];
    names.push_back(param.name);
    if (param.default_text) result[param.name] = param.default_text;
    if (names_program(param)) result[param.name] = find_program(param.default_text);
  }
  for (const auto& [name, given] : node.parameters) {
    const plumbline_param* param = kind.param(name);
    if (!param) {
      const auto near = near_names(name, names);
      const bool of_another_kind = node.use.at.line == 0 && given.at.line > 0;  // the kind is an override, this is not
      problems.push_back({given.at, owner + " has no parameter '" + name + "'" +
                                        (of_another_kind ? "; " + node.name + ".with." + name + "=~ leaves it out"
                                         : near.empty()  ? ""
                                                         : " — did you mean '" + near[0] + "'?")});
      continue;
    }
    if (given.is_list && !param->is_list) {
      problems.push_back({given.at, "parameter '" + name + "' of " + owner + " takes one value, found a list"});
      continue;
    }
    Checker checker(*param, owner, problems);
    std::string text;
    for (size_t i = 0; i < given.values.size(); ++i) text += (i ? "\x1f" : "") + checker.check(given.values[i]);
    result[name] = text;
  }
  for (const std::string& name : names)
    if (!result.count(name))
      problems.push_back(
          {node.at, "node '" + node.name + "' must say with: {" + name + ": …}: " + kind.param(name)->doc});
  return result;
}

}  // namespace plumbline::runtime
