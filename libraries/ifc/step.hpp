// Reader of ISO 10303-21 files (STEP physical files, the syntax of IFC).
//
// A file is read once to find where every instance stands: its number, its keyword and the place of its arguments.
// Arguments are parsed when somebody asks for them, because a building model is mostly triangles that nobody asks for.
// The bytes stay as they came, so that a writer can copy the file and add to it.
//
// Read leniently where real exporters err and nothing is lost by it (lower-case keywords, blanks inside `#1= X`, line
// breaks and unescaped solidi in strings, reals without a point, UTF-8 or Latin-1 bytes); everything else is an error
// that names line and column.
#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

namespace plumbline::step {

/// What is wrong, as "file:line:column: found …, expected …".
struct Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};

enum class Kind : std::uint8_t { null, derived, integer, real, text, enumeration, binary, reference, list, typed };

/// One argument of an instance.
struct Value {
  Kind kind = Kind::null;
  double number = 0;     ///< integer and real
  std::uint64_t id = 0;  ///< reference
  std::string text;  ///< text (UTF-8), enumeration (capitals, without points), binary (hex digits), keyword of typed
  std::vector<Value> items;  ///< list; the arguments of typed

  bool is_number() const { return kind == Kind::integer || kind == Kind::real; }
};

/// A keyword (capitals) and its arguments: a header entry, or one part of a complex instance.
struct Record {
  std::string keyword;
  std::vector<Value> arguments;
};

struct Instance {
  std::uint64_t id = 0;
  std::size_t begin = 0;      ///< offset of its '#'
  std::size_t arguments = 0;  ///< offset of the '(' after the keyword, or that opens a complex instance
  std::uint32_t type = 0;     ///< index of the keyword; see File::type_name
};

class Scanner;

class File {
 public:
  /// Takes the bytes of a file; `name` is for messages. Throws Error.
  File(std::string bytes, std::string name);
  /// Reads the file at `path`. Throws Error, also when it cannot be read.
  static File read(const std::string& path);

  const std::string& bytes() const { return bytes_; }
  const std::string& name() const { return name_; }
  const std::vector<Record>& header() const { return header_; }
  /// The names in FILE_SCHEMA, in capitals.
  const std::vector<std::string>& schemas() const { return schemas_; }

  const std::vector<Instance>& instances() const { return instances_; }  ///< in the order of the file
  const Instance* find(std::uint64_t id) const;                          ///< nullptr if there is none
  /// Keyword in capitals; empty for a complex instance.
  const std::string& type_name(const Instance& instance) const { return type_names_[instance.type]; }
  /// Indices into `instances()` of those with this keyword (capitals), in the order of the file.
  const std::vector<std::uint32_t>& of_type(std::string_view keyword) const;
  /// Every keyword that occurs, in the order of first appearance; the index is Instance::type.
  const std::vector<std::string>& type_names() const { return type_names_; }

  /// The arguments of a simple instance. Throws Error, also for a complex instance.
  std::vector<Value> arguments(const Instance& instance) const;
  /// The parts of an instance; a simple one has one part.
  std::vector<Record> records(const Instance& instance) const;

  std::uint64_t largest_id() const { return by_id_.empty() ? 0 : by_id_.back().first; }
  /// Offset of the ENDSEC that closes the (last) DATA section: where new instances go.
  std::size_t data_end() const { return data_end_; }
  /// "name:line:column" of an offset, both from 1.
  std::string where(std::size_t offset) const;

 private:
  struct TextHash {
    using is_transparent = void;
    std::size_t operator()(std::string_view text) const { return std::hash<std::string_view>{}(text); }
  };
  void read_index();
  bool read_section(Scanner& scanner);
  void read_header_entry(Scanner& scanner);
  void read_instance(Scanner& scanner);
  void sort_ids(const Scanner& scanner);
  void note_schemas();

  std::string bytes_, name_;
  std::vector<Record> header_;
  std::vector<std::string> schemas_;
  std::vector<Instance> instances_;
  std::vector<std::string> type_names_;
  std::unordered_map<std::string, std::uint32_t, TextHash, std::equal_to<>> types_;
  std::vector<std::vector<std::uint32_t>> by_type_;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> by_id_;  // ascending
  std::size_t data_end_ = 0;
};

}  // namespace plumbline::step
