#include "runtime/plugins/elf.hpp"

#include <elf.h>
#include <gnu/libc-version.h>
#include <link.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <set>
#include <stdexcept>

#include "runtime/base/digest.hpp"

namespace plumbline::runtime {

namespace {

constexpr size_t align4(size_t n) { return (n + 3) & ~size_t{3}; }

/// Descriptor of a note within a PT_NOTE segment; false if it holds none of that owner and type.
bool find_note(const char* data, size_t size, const std::string& owner, uint32_t type, std::string& descriptor) {
  size_t at = 0;
  while (at + sizeof(Elf64_Nhdr) <= size) {
    Elf64_Nhdr header;
    std::memcpy(&header, data + at, sizeof header);
    const size_t name = at + sizeof header;
    const size_t body = name + align4(header.n_namesz);
    if (body < name || body > size || header.n_descsz > size - body) return false;
    if (header.n_type == type && header.n_namesz == owner.size() + 1 &&
        std::memcmp(data + name, owner.c_str(), owner.size() + 1) == 0) {
      descriptor.assign(data + body, header.n_descsz);
      return true;
    }
    at = body + align4(header.n_descsz);
  }
  return false;
}

std::string read_range(std::ifstream& stream, uint64_t offset, uint64_t size, uint64_t file_size) {
  if (offset > file_size || size > file_size - offset)
    throw std::runtime_error("is a damaged ELF file: it ends before its own headers say (truncated copy?)");
  std::string bytes(size, '\0');
  stream.seekg(static_cast<std::streamoff>(offset));
  stream.read(bytes.data(), static_cast<std::streamsize>(size));
  return bytes;
}

Elf64_Ehdr read_elf_header(std::ifstream& stream, uint64_t file_size) {
  Elf64_Ehdr header{};
  const std::string bytes = read_range(stream, 0, std::min<uint64_t>(sizeof header, file_size), file_size);
  std::memcpy(&header, bytes.data(), bytes.size());
  if (bytes.size() < sizeof header || std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0)
    throw std::runtime_error("is not a shared library (no ELF header)");
#if defined(__x86_64__)
  constexpr uint16_t this_machine = EM_X86_64;
#elif defined(__aarch64__)
  constexpr uint16_t this_machine = EM_AARCH64;
#else
  const uint16_t this_machine = header.e_machine;
#endif
  if (header.e_ident[EI_CLASS] != ELFCLASS64 || header.e_machine != this_machine)
    throw std::runtime_error("is built for another architecture (ELF machine " + std::to_string(header.e_machine) +
                             ", this host is " + std::to_string(this_machine) + "); build it on this machine");
  if (header.e_type != ET_DYN || header.e_phentsize != sizeof(Elf64_Phdr))
    throw std::runtime_error("is an ELF file but not a shared library");
  return header;
}

}  // namespace

std::string read_elf_note(const std::filesystem::path& library, const std::string& owner, uint32_t type) {
  std::ifstream stream(library, std::ios::binary);
  if (!stream) throw std::runtime_error(std::string("cannot be read: ") + std::strerror(errno));
  const uint64_t file_size = std::filesystem::file_size(library);
  const Elf64_Ehdr header = read_elf_header(stream, file_size);
  const std::string table =
      read_range(stream, header.e_phoff, uint64_t{header.e_phnum} * sizeof(Elf64_Phdr), file_size);
  std::string descriptor;
  for (size_t i = 0; i < header.e_phnum; ++i) {
    Elf64_Phdr segment;
    std::memcpy(&segment, table.data() + i * sizeof segment, sizeof segment);
    if (segment.p_type != PT_NOTE) continue;
    const std::string notes = read_range(stream, segment.p_offset, segment.p_filesz, file_size);
    if (find_note(notes.data(), notes.size(), owner, type, descriptor)) return descriptor;
  }
  throw std::runtime_error("is a shared library but no Plumbline plugin (it has no '" + owner +
                           "' note; PLUMBLINE_PLUGIN(...) in one source file makes it)");
}

namespace {

/// Program headers and what each covers, of an ELF-64 file of any kind; `take` says whether it has seen enough.
template <typename Take>
void each_segment(const std::filesystem::path& file, uint32_t type, const Take& take) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw std::runtime_error(file.string() + " cannot be read: " + std::strerror(errno));
  const uint64_t size = std::filesystem::file_size(file);
  Elf64_Ehdr header{};
  if (size < sizeof header) return;
  std::memcpy(&header, read_range(stream, 0, sizeof header, size).data(), sizeof header);
  if (std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0 || header.e_ident[EI_CLASS] != ELFCLASS64 ||
      header.e_phentsize != sizeof(Elf64_Phdr))
    return;
  const std::string table = read_range(stream, header.e_phoff, uint64_t{header.e_phnum} * sizeof(Elf64_Phdr), size);
  for (size_t i = 0; i < header.e_phnum; ++i) {
    Elf64_Phdr segment;
    std::memcpy(&segment, table.data() + i * sizeof segment, sizeof segment);
    if (segment.p_type == type && take(read_range(stream, segment.p_offset, segment.p_filesz, size))) return;
  }
}

std::string hex(const std::string& bytes) {
  std::string text;
  for (const unsigned char c : bytes) {
    text += "0123456789abcdef"[c >> 4];
    text += "0123456789abcdef"[c & 15];
  }
  return text;
}

}  // namespace

std::filesystem::path elf_interpreter(const std::filesystem::path& program) {
  std::string path;
  each_segment(program, PT_INTERP, [&](const std::string& bytes) {
    path = bytes.c_str();
    return true;
  });
  return path;
}

std::string id_of_library(const std::filesystem::path& library) {
  std::string id;
  each_segment(library, PT_NOTE, [&](const std::string& notes) {
    return find_note(notes.data(), notes.size(), "GNU", NT_GNU_BUILD_ID, id);
  });
  return id.empty() ? "sha256-" + sha256_of_file(library) : hex(id);
}

namespace {

struct LoadedObject {
  uintptr_t lowest = 0, highest = 0;
  std::string soname, build_id, path;
  std::vector<std::string> needed;
};

void read_dynamic(const dl_phdr_info& info, const ElfW(Phdr) & segment, LoadedObject& object) {
  const auto* entry = reinterpret_cast<const ElfW(Dyn)*>(info.dlpi_addr + segment.p_vaddr);
  const char* strings = nullptr;
  for (const auto* e = entry; e->d_tag != DT_NULL; ++e)
    if (e->d_tag == DT_STRTAB) strings = reinterpret_cast<const char*>(e->d_un.d_ptr);
  // The vdso keeps an unrelocated address here; it has nothing we need.
  if (!strings || reinterpret_cast<uintptr_t>(strings) < info.dlpi_addr) return;
  for (const auto* e = entry; e->d_tag != DT_NULL; ++e) {
    if (e->d_tag == DT_NEEDED) object.needed.emplace_back(strings + e->d_un.d_val);
    if (e->d_tag == DT_SONAME) object.soname = strings + e->d_un.d_val;
  }
}

int collect_object(dl_phdr_info* info, size_t, void* result) {
  LoadedObject object;
  object.lowest = UINTPTR_MAX;
  for (int i = 0; i < info->dlpi_phnum; ++i) {
    const ElfW(Phdr)& segment = info->dlpi_phdr[i];
    const uintptr_t start = info->dlpi_addr + segment.p_vaddr;
    if (segment.p_type == PT_LOAD) {
      object.lowest = std::min(object.lowest, start);
      object.highest = std::max(object.highest, start + segment.p_memsz);
    } else if (segment.p_type == PT_NOTE) {
      std::string id;
      if (object.build_id.empty() &&
          find_note(reinterpret_cast<const char*>(start), segment.p_memsz, "GNU", NT_GNU_BUILD_ID, id))
        object.build_id = hex(id);
    } else if (segment.p_type == PT_DYNAMIC) {
      read_dynamic(*info, segment, object);
    }
  }
  if (info->dlpi_name) object.path = info->dlpi_name;
  if (object.soname.empty()) object.soname = std::filesystem::path(object.path).filename();
  static_cast<std::vector<LoadedObject>*>(result)->push_back(object);
  return 0;
}

}  // namespace

/// A library that was linked without a build id is told by its content.
static std::string id_of(const LoadedObject& object) {
  return object.build_id.empty() ? id_of_library(object.path) : object.build_id;
}

/// Libraries that fetch or show: no number of a node comes through them, and what they need is needed for that.
static bool only_fetches_or_shows(const std::string& soname) {
  for (const char* name : {"libcurl.so", "libcurl-gnutls.so", "libX11.so", "libxcb.so", "libGL.so", "libGLX.so",
                           "libOpenGL.so", "libEGL.so", "libwayland-client.so"})
    if (soname.starts_with(name)) return true;
  return false;
}

/// Parts of the C library. They are told by its release and not by their builds, which every security update makes
/// anew: numbers are read and written correctly rounded, memory is copied. How it sorts what is alike has changed with
/// a release (2.37).
static bool is_of_c_library(const std::string& soname) {
  for (const char* name :
       {"libc.so.6", "ld-linux", "libpthread.so.0", "libdl.so.2", "librt.so.1", "libresolv.so.2", "libm.so.6"})
    if (soname.starts_with(name)) return true;
  return false;
}

/// What libm computes here, as a hash of the bits that its functions give at fixed arguments: an update that computes
/// the same is the same, and a processor for which it takes other code is not.
static const std::string& results_of_libm() {
  static const std::string hash = [] {
    std::vector<double> results;
    using Function = double (*)(double);
    const auto all = [&](std::initializer_list<Function> functions, double from, double to) {
      for (const Function function : functions)
        for (int i = 0; i < 200; ++i) results.push_back(function(from + (to - from) * (i + 0.37) / 200));
    };
    all({std::sin, std::cos, std::tan, std::atan, std::exp, std::sinh, std::cosh, std::tanh, std::cbrt, std::erf,
         std::erfc},
        -9, 9);
    all({std::asin, std::acos, std::expm1, std::atanh}, -1, 1);
    all({std::log, std::log2, std::log10, std::log1p, std::tgamma, std::lgamma, std::asinh}, 0, 30);
    all({std::sin, std::cos}, -1e6, 1e6);
    for (int i = 0; i < 400; ++i) {
      const double a = 0.01 + 0.07 * i, b = 11.3 - 0.05 * i;
      for (const double value :
           {std::pow(a, b), std::atan2(b, a), std::hypot(a, b), std::fmod(1000 * a, b), std::exp2(b)})
        results.push_back(value);
    }
    return sha256_of(results.data(), results.size() * sizeof(double));
  }();
  return hash;
}

namespace {

using ByName = std::map<std::string, const LoadedObject*>;

/// Names of all that `start` needs, and what that needs; `behind` false: not beyond those that only fetch or show.
std::set<std::string> needed_by(const LoadedObject* start, const ByName& by_name, bool behind) {
  std::set<std::string> seen;
  std::vector<const LoadedObject*> waiting;
  if (start) waiting.push_back(start);
  while (!waiting.empty()) {
    const LoadedObject* object = waiting.back();
    waiting.pop_back();
    for (const std::string& needed : object->needed) {
      const std::string name = std::filesystem::path(needed).filename();  // one without a soname is needed by its path
      if (!behind && object != start && only_fetches_or_shows(name)) continue;
      if (const auto found = by_name.find(name); found != by_name.end() && seen.insert(name).second)
        waiting.push_back(found->second);
    }
  }
  return seen;
}

}  // namespace

std::vector<std::string> linked_build_ids(const void* address) {
  std::vector<LoadedObject> objects;
  dl_iterate_phdr(&collect_object, &objects);
  ByName by_name;
  const LoadedObject* start = nullptr;
  const auto where = reinterpret_cast<uintptr_t>(address);
  for (const LoadedObject& object : objects) {
    by_name.emplace(object.soname, &object);
    if (object.lowest <= where && where < object.highest) start = &object;
  }
  const std::set<std::string> computing = needed_by(start, by_name, false);
  std::vector<std::string> ids;
  for (const std::string& name : needed_by(start, by_name, true)) {
    const bool counts = computing.count(name) > 0 && !is_of_c_library(name);
    ids.push_back(name + ":" + id_of(*by_name[name]) + std::string(counts ? "" : kNoPartOfKeys));
    if (name.starts_with("libc.so.6")) ids.push_back(std::string("C library:glibc ") + gnu_get_libc_version());
    if (name.starts_with("libm.so.6")) ids.push_back("results of libm:" + results_of_libm());
  }
  std::sort(ids.begin(), ids.end());
  return ids;
}

}  // namespace plumbline::runtime
