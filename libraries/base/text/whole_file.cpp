#include "base/text/whole_file.hpp"

#include <cerrno>
#include <cstdio>
#include <memory>
#include <system_error>

#include "plumbline/failure.hpp"

namespace plumbline::text {

std::string read_whole(const std::filesystem::path& file) {
  struct Close {
    void operator()(std::FILE* stream) const { std::fclose(stream); }
  };
  const std::unique_ptr<std::FILE, Close> stream(std::fopen(file.c_str(), "rbe"));
  std::string bytes;
  char piece[1 << 16];
  for (std::size_t got; stream && (got = std::fread(piece, 1, sizeof piece, stream.get())) > 0;)
    bytes.append(piece, got);
  if (!stream || std::ferror(stream.get()))
    throw BadInput("cannot read " + file.string() + ": " + std::generic_category().message(errno));
  return bytes;
}

}  // namespace plumbline::text
