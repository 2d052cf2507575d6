#include "runtime/graph/output_name.hpp"

#include <algorithm>

#include "runtime/base/printable.hpp"

namespace plumbline::runtime {

std::string output_name_problem(const std::string& name) {
  const std::string named = "'" + printable_line(name) + "' cannot be the name of an output: ";
  if (name.empty()) return named + "it is empty";
  if (name[0] == '/') return named + "it must lie under the output folder";
  size_t start = 0;
  for (;;) {
    const size_t end = std::min(name.find('/', start), name.size());
    const std::string part = name.substr(start, end - start);
    if (part.empty() || part == "." || part == "..")
      return named + "'" + (part.empty() ? "/" : part) + "' names no file under the output folder";
    if (part.size() > 255) return named + "a part of it has more than 255 bytes";
    if (part.starts_with(".plumbline-") || part == ".run.jsonl.new")
      return named + "names like '" + part + "' are the program's own";
    for (const char c : part)
      if (static_cast<unsigned char>(c) < 32 || c == 127) return named + "it holds a control character";
    if (end == name.size()) break;
    start = end + 1;
  }
  return name == "run.jsonl" || name.starts_with("run.jsonl/") ? named + "the record of the run goes there" : "";
}

}  // namespace plumbline::runtime
