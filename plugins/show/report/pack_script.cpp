// pack_script IN.js OUT.cpp NAME "NOTICE" : a script, compressed and in base64, as a string of the program. Runs while
// building.
#include <zlib.h>

#include <fstream>
#include <iostream>
#include <iterator>
#include <string>

namespace {

std::string base64(const std::string& bytes) {
  static const char* const digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned triple = 0;
    for (std::size_t k = 0; k < 3; ++k)
      triple = triple << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (int k = 0; k < 4; ++k)
      text += i + static_cast<std::size_t>(k) > bytes.size() ? '=' : digits[triple >> (18 - 6 * k) & 63];
  }
  return text;
}

}  // namespace

int main(int count, char** arguments) {
  std::ifstream in(count == 5 ? arguments[1] : "", std::ios::binary);
  if (!in) {
    std::cerr << "usage: pack_script IN.js OUT.cpp NAME NOTICE; IN.js must be readable\n";
    return 1;
  }
  const std::string script =
      "/* " + std::string(arguments[4]) + " */\n" + std::string(std::istreambuf_iterator<char>(in), {});
  uLongf size = compressBound(static_cast<uLong>(script.size()));
  std::string packed(size, '\0');
  if (compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(script.data()),
                static_cast<uLong>(script.size()), Z_BEST_COMPRESSION) != Z_OK)
    return 1;
  packed.resize(size);
  std::ofstream out(arguments[2]);
  out << "namespace plumbline::report {\nextern const char* const " << arguments[3] << ";\nconst char* const "
      << arguments[3] << " =\n";
  const std::string text = base64(packed);
  for (std::size_t at = 0; at < text.size(); at += 100) out << "    \"" << text.substr(at, 100) << "\"\n";
  out << "    ;\n}  // namespace plumbline::report\n";
  return out.good() ? 0 : 1;
}
