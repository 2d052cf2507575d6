// Reader of ISO 10303-21 files (STEP physical files, the syntax of IFC).
//
// Index, do not parse: a file is looked through once to find where every instance begins and what its keyword is, 8.25
// bytes an instance (its number stands in the text). Arguments are parsed when somebody asks for them, because a
// building model is mostly triangles that nobody asks for; so an instance whose arguments are damaged is an error of
// the one who reads it, not of the file. The bytes stay as they came, mapped rather than copied where they lie in a
// file, so that a writer can copy the file and add to it.
//
// Read leniently where real exporters err and nothing is lost by it (lower-case keywords, blanks inside `#1= X`, line
// breaks and unescaped solidi in strings, reals without a point, UTF-8 or Latin-1 bytes, nothing where $ or * belongs);
// everything else is an error that names line and column.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "plumbline/failure.hpp"

namespace plumbline::step {

/// What is wrong, as "file:line:column: found …, expected …".
struct Error : BadInput {
  using BadInput::BadInput;
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

/// An instance as the index knows it.
struct Instance {
  std::uint64_t id = 0;
  std::uint64_t begin = 0;  ///< offset of its '#'
  std::uint32_t type = 0;   ///< index of the keyword; see File::type_name
  std::uint32_t index = 0;  ///< in the order of the file
};

class File;

/// The instances of a file, in its order. The number of one is read from the text when it is asked for.
class Instances {
 public:
  class Iterator {
   public:
    Iterator(const File& file, std::size_t index) : file_(&file), index_(index) {}
    Instance operator*() const;
    Iterator& operator++() {
      ++index_;
      return *this;
    }
    bool operator==(const Iterator& other) const { return index_ == other.index_; }

   private:
    const File* file_;
    std::size_t index_;
  };

  explicit Instances(const File& file) : file_(file) {}
  std::size_t size() const;
  bool empty() const { return size() == 0; }
  Instance operator[](std::size_t index) const { return *Iterator(file_, index); }
  std::uint32_t type(std::size_t index) const;  ///< without reading the number
  Iterator begin() const { return {file_, 0}; }
  Iterator end() const { return {file_, size()}; }

 private:
  const File& file_;
};

class Scanner;

class File {
 public:
  /// Takes the bytes of a file; `name` is for messages. Throws Error. Here and below the file may be an ifcZIP archive
  /// of one model (zip_reader.hpp): `bytes()` are then those of the model; and ifcXML (xml_reader.hpp): they are then
  /// those of the STEP file that says the same, and places in messages those of the XML.
  File(std::string bytes, std::string name);
  /// Looks at bytes that the caller keeps alive and unchanged. Throws Error.
  static File view(std::string_view bytes, std::string name);
  /// Maps the file at `path`, for reading only; `name` is for messages, the path unless given. Throws Error, also when
  /// it cannot be read.
  static File read(const std::string& path, std::string name = {});

  std::string_view bytes() const { return bytes_; }
  /// Whether the model came as ifcXML.
  bool was_xml() const { return !xml_lines_.empty(); }
  const std::string& name() const { return name_; }
  const std::vector<Record>& header() const { return header_; }
  /// The names in FILE_SCHEMA, in capitals.
  const std::vector<std::string>& schemas() const { return schemas_; }

  Instances instances() const { return Instances(*this); }
  std::optional<Instance> find(std::uint64_t id) const;
  /// Keyword in capitals; empty for a complex instance.
  const std::string& type_name(const Instance& instance) const { return type_names_[instance.type]; }
  /// Indices into `instances()` of those with this keyword (capitals), in the order of the file; found when first asked
  /// for. May be called from several threads.
  const std::vector<std::uint32_t>& of_type(std::string_view keyword) const;
  /// Every keyword that occurs, in the order of first appearance; the index is Instance::type.
  const std::vector<std::string>& type_names() const { return type_names_; }

  /// The arguments of a simple instance. Throws Error, also for a complex instance.
  std::vector<Value> arguments(const Instance& instance) const;
  /// The parts of an instance; a simple one has one part.
  std::vector<Record> records(const Instance& instance) const;

  /// Offset of the '(' after the keyword, or that opens a complex instance.
  std::size_t arguments_at(const Instance& instance) const;
  /// Whether the text stands somewhere between the instance's '#' and the next one's: a look before parsing.
  bool contains(const Instance& instance, std::string_view text) const;

  std::uint64_t largest_id() const { return largest_id_; }
  /// The first number above those of all instances and of all references: also of those to nothing, which an addition
  /// would otherwise fill. 0 if there is none. Looks at all bytes.
  std::uint64_t free_id() const;
  /// Offset of the ENDSEC that closes the (last) DATA section: where new instances go.
  std::size_t data_end() const { return data_end_; }
  /// "name:line:column" of an offset, both from 1; of what came as XML "name:line" there.
  std::string where(std::size_t offset) const;

 private:
  friend class Instances;
  struct Lists;
  struct Entry {
    std::uint64_t begin : 40 = 0;
    std::uint64_t type : 24 = 0;
  };
  static_assert(sizeof(Entry) == 8);
  /// A number of every so many is kept for searching; the others are read from the text.
  static constexpr std::size_t kMark = 32;
  static constexpr std::uint32_t kNone = UINT32_MAX;

  Instance instance(std::size_t index) const {
    const Entry& entry = entries_[index];
    return {id_at(entry.begin), entry.begin, static_cast<std::uint32_t>(entry.type), static_cast<std::uint32_t>(index)};
  }
  std::uint64_t id_at(std::uint64_t begin) const;
  std::uint64_t largest_reference(std::size_t index) const;
  std::size_t end_of(std::size_t index) const {
    return index + 1 < entries_.size() ? static_cast<std::size_t>(entries_[index + 1].begin) : data_end_;
  }
  /// Index of the instance that stands in a place of the order of ascending numbers.
  std::size_t at_place(std::size_t place) const { return by_id_.empty() ? place : by_id_[place]; }
  File(std::shared_ptr<const void> owner, std::string_view bytes, std::string name);
  void read_index();
  bool read_section(Scanner& scanner);
  void read_header_entry(Scanner& scanner);
  void read_instance(Scanner& scanner);
  std::uint32_t type_of(Scanner& scanner);
  void sort_ids(const Scanner& scanner);
  void note_schemas();

  std::shared_ptr<const void> owner_;  // of the bytes; null if that is the caller
  std::string_view bytes_;
  std::string name_;
  std::vector<std::uint32_t> xml_lines_;  // of each line of what came as XML
  std::vector<Record> header_;
  std::vector<std::string> schemas_;
  std::vector<Entry> entries_;
  std::vector<std::string> type_names_;
  std::vector<std::uint32_t> type_counts_;
  std::vector<std::uint32_t> type_table_;  // hash table of indices into type_names_, plus one
  // Where the numbers do not ascend: the index of each, if there are few gaps; else their order.
  std::vector<std::uint32_t> by_number_, by_id_;
  std::vector<std::uint64_t> marks_;  // in the order of ascending numbers, that of every kMark-th
  bool ascending_ = true;
  std::uint64_t last_id_ = 0;     // while reading
  std::shared_ptr<Lists> lists_;  // of_type
  std::uint64_t largest_id_ = 0;
  std::size_t data_end_ = 0;
};

inline Instance Instances::Iterator::operator*() const { return file_->instance(index_); }
inline std::size_t Instances::size() const { return file_.entries_.size(); }
inline std::uint32_t Instances::type(std::size_t index) const {
  return static_cast<std::uint32_t>(file_.entries_[index].type);
}

}  // namespace plumbline::step
