// First pass: the index of instances, and what is looked up in it.
#include "building/step/step.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <mutex>
#include <unordered_map>

#include "building/step/step_scanner.hpp"
#include "building/step/xml_reader.hpp"
#include "building/step/zip_reader.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::step {
namespace {

constexpr std::array<bool, 256> kInKeyword = [] {
  std::array<bool, 256> table{};
  for (int c = 0; c < 128; ++c) {
    const char letter = static_cast<char>(c);
    table[c] = is_letter(letter) || is_digit(letter) || letter == '-';
  }
  return table;
}();

/// Of a keyword, small letters like capitals: the bit between them is left out. Eight bytes at a time, because a model
/// has millions of instances.
std::uint64_t hash_of(std::string_view keyword) {
  std::uint64_t hash = keyword.size();
  while (!keyword.empty()) {
    const std::size_t size = std::min<std::size_t>(keyword.size(), 8);
    std::uint64_t word = 0;
    std::memcpy(&word, keyword.data(), size);
    hash = (hash ^ (word & 0xDFDFDFDFDFDFDFDF)) * 0x9E3779B97F4A7C15;
    hash ^= hash >> 32;
    keyword.remove_prefix(size);
  }
  return hash;
}

bool same_keyword(const std::string& capitals, std::string_view keyword) {
  if (capitals.size() != keyword.size()) return false;
  return std::memcmp(capitals.data(), keyword.data(), keyword.size()) == 0 ||
         std::equal(capitals.begin(), capitals.end(), keyword.begin(), [](char a, char b) { return a == upper(b); });
}

std::string unzipped(const std::string& archive, const std::string& name) {
  try {
    return unzip_ifc(archive).content;
  } catch (const std::runtime_error& error) {
    throw Error(name + ": " + error.what());
  }
}

/// A file in memory, for reading only.
struct Mapping {
  void* data = MAP_FAILED;
  std::size_t size = 0;
  Mapping() = default;
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;
  ~Mapping() {
    if (data != MAP_FAILED) munmap(data, size);
  }
};

}  // namespace

struct File::Lists {
  std::mutex mutex;
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> by_type;
};

File File::read(const std::string& path, std::string name) {
  auto mapping = std::make_shared<Mapping>();
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  struct stat status {};
  const bool regular = descriptor >= 0 && fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
  if (regular && status.st_size > 0) {
    mapping->size = static_cast<std::size_t>(status.st_size);
    mapping->data = mmap(nullptr, mapping->size, PROT_READ, MAP_PRIVATE, descriptor, 0);
  }
  if (descriptor >= 0) close(descriptor);
  const bool empty = regular && status.st_size == 0;
  if (!regular || (!empty && mapping->data == MAP_FAILED))
    throw Error(path + ": cannot be read, expected an IFC or STEP file");
  const std::string_view bytes(empty ? "" : static_cast<const char*>(mapping->data), mapping->size);
  if (is_zip(bytes) || is_xml(bytes)) return view(bytes, name.empty() ? path : std::move(name));
  return File(std::move(mapping), bytes, name.empty() ? path : std::move(name));
}

File File::view(std::string_view bytes, std::string name) {
  if (is_zip(bytes) || is_xml(bytes)) return File(std::string(bytes), std::move(name));
  return File(nullptr, bytes, std::move(name));
}

File::File(std::string bytes, std::string name) : name_(std::move(name)), lists_(std::make_shared<Lists>()) {
  if (is_zip(bytes)) bytes = unzipped(bytes, name_);
  if (is_xml(bytes)) {
    StepOfXml converted = step_of_xml(bytes, name_);
    bytes = std::move(converted.text), xml_lines_ = std::move(converted.lines);
  }
  auto owner = std::make_shared<const std::string>(std::move(bytes));
  bytes_ = *owner;
  owner_ = std::move(owner);
  read_index();
}

File::File(std::shared_ptr<const void> owner, std::string_view bytes, std::string name)
    : owner_(std::move(owner)), bytes_(bytes), name_(std::move(name)), lists_(std::make_shared<Lists>()) {
  read_index();
}

void File::read_index() {
  Scanner scanner(bytes_, name_);
  if (bytes_.size() >> 40) scanner.fail("a file of less than a terabyte");
  type_table_.assign(1024, 0);
  // Pages of a reserve that are never written take no memory; growing by doubling would copy the index several times.
  entries_.reserve(bytes_.size() / 24);
  if (scanner.starts_with("\xEF\xBB\xBF")) scanner.at = 3;  // a byte order mark
  scanner.skip_blank();
  if (!scanner.starts_with("ISO-10303-21")) scanner.fail("'ISO-10303-21;' at the start of a STEP file");
  scanner.read_keyword();
  scanner.expect(';', "after ISO-10303-21");
  while (read_section(scanner)) {
  }
  if (data_end_ == 0) scanner.fail("a DATA section in the file");
  note_schemas();
  sort_ids(scanner);
}

/// False at the end of the file's text.
bool File::read_section(Scanner& scanner) {
  scanner.skip_blank();
  if (scanner.ended()) scanner.fail("END-ISO-10303-21; the file seems to be cut off");
  const std::size_t keyword_at = scanner.at;
  const std::string section = scanner.read_keyword();
  const bool known = section == "HEADER" || section == "DATA";
  scanner.skip_blank();
  if (section == "DATA" && scanner.peek() == '(') scanner.skip_arguments();  // edition 3 names its sections
  scanner.skip_blank();
  scanner.expect(';', ("after " + section).c_str());
  if (section == "END-ISO-10303-21") return false;
  if (!known && section != "ANCHOR" && section != "REFERENCE" && section != "SIGNATURE")
    scanner.fail_at(keyword_at, "found '" + section + "', expected HEADER, DATA or END-ISO-10303-21");
  for (;;) {
    scanner.skip_blank();
    if (section == "DATA" && scanner.peek() == '#') {
      if (entries_.size() % 4096 == 0) stop_point();
      read_instance(scanner);
      continue;
    }
    if (!known) scanner.at = std::min(bytes_.find("ENDSEC", scanner.at), bytes_.size());  // holds nothing for us
    if (scanner.ended()) scanner.fail("ENDSEC at the end of section " + section + "; the file seems to be cut off");
    const std::size_t entry = scanner.at;
    if (scanner.starts_with("ENDSEC") || section == "DATA") {
      if (scanner.read_keyword() != "ENDSEC") scanner.fail_at(entry, "expected '#' of an instance or ENDSEC here");
      scanner.skip_blank();
      scanner.expect(';', "after ENDSEC");
      if (section == "DATA") data_end_ = entry;
      return true;
    }
    read_header_entry(scanner);
  }
}

void File::read_header_entry(Scanner& scanner) {
  std::string keyword = scanner.read_keyword();
  scanner.skip_blank();
  if (scanner.peek() != '(') scanner.fail("'(' before the arguments of " + keyword);
  header_.push_back({std::move(keyword), scanner.read_list(0)});
  scanner.skip_blank();
  scanner.expect(';', "at the end of the header entry");
}

void File::read_instance(Scanner& scanner) {
  Entry entry;
  entry.begin = scanner.at++ & ((std::uint64_t{1} << 40) - 1);
  const std::uint64_t id = scanner.read_number();
  scanner.skip_blank();
  scanner.expect('=', "after the number of the instance");
  scanner.skip_blank();
  entry.type = type_of(scanner) & 0xFFFFFF;
  scanner.skip_blank();
  if (scanner.peek() != '(') scanner.fail("'(' before the arguments of #" + std::to_string(id));
  scanner.skip_instance(id);
  if (!entries_.empty() && id <= last_id_) ascending_ = false;
  if (ascending_ && entries_.size() % kMark == 0) marks_.push_back(id);
  last_id_ = id;
  largest_id_ = std::max(largest_id_, id);
  ++type_counts_[entry.type];
  entries_.push_back(entry);
}

/// Index of the keyword at the cursor, which is left behind it; the empty keyword of a complex instance at '('. Looked
/// up by its bytes, because a model has millions of instances and some hundred keywords.
std::uint32_t File::type_of(Scanner& scanner) {
  const std::size_t begin = scanner.at;
  if (scanner.peek() != '(' && !is_letter(scanner.peek())) scanner.fail("a keyword");
  std::size_t end = begin;
  while (end < bytes_.size() && kInKeyword[static_cast<unsigned char>(bytes_[end])]) ++end;
  const std::string_view keyword = bytes_.substr(begin, end - begin);
  const std::uint64_t hash = hash_of(keyword);
  scanner.at = end;
  const std::size_t mask = type_table_.size() - 1;
  std::size_t slot = hash & mask;
  for (; type_table_[slot] != 0; slot = (slot + 1) & mask)
    if (same_keyword(type_names_[type_table_[slot] - 1], keyword)) return type_table_[slot] - 1;
  if (type_names_.size() >= 60000) scanner.fail_at(begin, "found more than 60000 keywords, expected those of IFC");
  std::string capitals(keyword);
  for (char& c : capitals) c = upper(c);
  type_names_.push_back(std::move(capitals));
  type_counts_.push_back(0);
  type_table_[slot] = static_cast<std::uint32_t>(type_names_.size());
  if (2 * type_names_.size() > type_table_.size()) {
    std::vector<std::uint32_t> larger(2 * type_table_.size(), 0);
    for (std::uint32_t i = 0; i < type_names_.size(); ++i) {
      std::size_t place = hash_of(type_names_[i]) & (larger.size() - 1);
      while (larger[place] != 0) place = (place + 1) & (larger.size() - 1);
      larger[place] = i + 1;
    }
    type_table_ = std::move(larger);
  }
  return static_cast<std::uint32_t>(type_names_.size() - 1);
}

void File::note_schemas() {
  for (const Record& record : header_) {
    if (record.keyword != "FILE_SCHEMA" || record.arguments.empty()) continue;
    for (const Value& schema : record.arguments[0].items) {
      schemas_.push_back(schema.text);
      for (char& c : schemas_.back()) c = upper(c);
    }
  }
}

void File::sort_ids(const Scanner& scanner) {
  if (ascending_) return;
  marks_ = {};
  const auto twice = [&](std::uint64_t id, std::uint32_t first, std::uint32_t second) {
    scanner.fail_at(entries_[second].begin, "found #" + std::to_string(id) +
                                                " a second time, expected every number once; the first is at " +
                                                where(entries_[first].begin));
  };
  // Where few numbers are left out, a table of all of them is smaller than any sorting, and quicker.
  if (largest_id_ / 2 <= entries_.size()) {
    by_number_.assign(static_cast<std::size_t>(largest_id_) + 1, kNone);
    for (std::uint32_t i = 0; i < entries_.size(); ++i) {
      const std::uint64_t id = id_at(entries_[i].begin);
      if (by_number_[id] != kNone) twice(id, by_number_[id], i);
      by_number_[id] = i;
    }
    return;
  }
  std::vector<std::uint64_t> ids(entries_.size());
  for (std::size_t i = 0; i < ids.size(); ++i) ids[i] = id_at(entries_[i].begin);
  by_id_.resize(ids.size());
  for (std::uint32_t i = 0; i < by_id_.size(); ++i) by_id_[i] = i;
  std::sort(by_id_.begin(), by_id_.end(),
            [&](std::uint32_t a, std::uint32_t b) { return ids[a] != ids[b] ? ids[a] < ids[b] : a < b; });
  for (std::size_t i = 0; i < by_id_.size(); ++i) {
    if (i % kMark == 0) marks_.push_back(ids[by_id_[i]]);
    if (i > 0 && ids[by_id_[i - 1]] == ids[by_id_[i]]) twice(ids[by_id_[i]], by_id_[i - 1], by_id_[i]);
  }
}

std::uint64_t File::id_at(std::uint64_t begin) const {
  std::uint64_t id = 0;
  std::from_chars(bytes_.data() + begin + 1, bytes_.data() + bytes_.size(), id);
  return id;
}

std::optional<Instance> File::find(std::uint64_t id) const {
  if (!by_number_.empty())
    return id < by_number_.size() && by_number_[id] != kNone ? std::optional(instance(by_number_[id])) : std::nullopt;
  const auto mark = std::upper_bound(marks_.begin(), marks_.end(), id);
  if (mark == marks_.begin()) return std::nullopt;
  std::size_t first = static_cast<std::size_t>(mark - marks_.begin() - 1) * kMark;
  // Numbers ascend by one at least, so it stands no further behind the mark than its number does.
  std::size_t end = std::min(first + kMark, entries_.size());
  if (id - mark[-1] < kMark) end = std::min(end, first + static_cast<std::size_t>(id - mark[-1]) + 1);
  // In most files the numbers have no gaps: the last place first.
  for (std::size_t place = end - 1; first < end; place = first + (end - first) / 2) {
    const std::size_t index = at_place(place);
    const std::uint64_t found = id_at(entries_[index].begin);
    if (found == id) return instance(index);
    if (found < id)
      first = place + 1;
    else
      end = place;
  }
  return std::nullopt;
}

const std::vector<std::uint32_t>& File::of_type(std::string_view keyword) const {
  static const std::vector<std::uint32_t> none;
  const auto name = std::find(type_names_.begin(), type_names_.end(), keyword);
  if (name == type_names_.end()) return none;
  const auto type = static_cast<std::uint32_t>(name - type_names_.begin());
  const std::lock_guard lock(lists_->mutex);
  const auto [list, added] = lists_->by_type.try_emplace(type);
  if (added) {
    list->second.reserve(type_counts_[type]);
    for (std::uint32_t i = 0; list->second.size() < type_counts_[type]; ++i)
      if (entries_[i].type == type) list->second.push_back(i);
  }
  return list->second;
}

std::size_t File::arguments_at(const Instance& instance) const {
  Scanner scanner(bytes_, name_, instance.begin + 1);
  scanner.read_number();
  scanner.skip_blank();
  scanner.expect('=', "after the number of the instance");
  scanner.skip_blank();
  if (scanner.peek() != '(') scanner.read_keyword();
  scanner.skip_blank();
  return scanner.at;
}

bool File::contains(const Instance& instance, std::string_view text) const {
  return bytes_.substr(instance.begin, end_of(instance.index) - instance.begin).find(text) != std::string_view::npos;
}

/// Outside strings and comments, in the arguments of an instance; 0 if it refers to nothing.
std::uint64_t File::largest_reference(std::size_t index) const {
  std::uint64_t largest = 0;
  Scanner scanner(bytes_, name_, arguments_at(instance(index)));
  while (scanner.at < end_of(index)) {
    const char c = scanner.peek();
    if (c == '\'' || c == '"')
      scanner.skip_string();
    else if (scanner.starts_with("/*"))
      scanner.skip_blank();
    else if (c == '#')
      largest = std::max(largest, id_at(scanner.at++));
    else
      ++scanner.at;
  }
  return largest;
}

std::uint64_t File::free_id() const {
  std::uint64_t largest = largest_id_;
  for (std::size_t at = bytes_.find('#'); at < data_end_; at = bytes_.find('#', at + 1)) {
    std::uint64_t id = 0;  // a number that does not fit in it refers to nothing that could be added
    for (std::size_t digit = at + 1; is_digit(bytes_[digit]); ++digit)
      id = 10 * id + static_cast<std::uint64_t>(bytes_[digit] - '0');
    if (id <= largest) continue;
    // Rare: a reference to nothing, or a text.
    const auto behind = std::upper_bound(entries_.begin(), entries_.end(), at,
                                         [](std::size_t offset, const Entry& entry) { return offset < entry.begin; });
    if (behind == entries_.begin()) continue;
    const auto index = static_cast<std::size_t>(behind - entries_.begin()) - 1;
    largest = std::max(largest, largest_reference(index));
    at = end_of(index) - 1;
  }
  return largest + 1;
}

std::string File::where(std::size_t offset) const {
  if (xml_lines_.empty()) return place(bytes_, name_, offset);
  const auto line = static_cast<std::size_t>(
      std::count(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(std::min(offset, bytes_.size())), '\n'));
  return name_ + ":" + std::to_string(line < xml_lines_.size() ? xml_lines_[line] : 0);
}

}  // namespace plumbline::step
