#include "show/bench/drawing.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cstdint>

#include "base/text/xml_text.hpp"

namespace plumbline::bench {

namespace {

std::string number(double value) { return fmt::format("{:.2f}", value); }

/// Code points of UTF-8; what is none becomes '?'.
std::vector<std::uint32_t> code_points(const std::string& text) {
  std::vector<std::uint32_t> points;
  for (std::size_t i = 0; i < text.size();) {
    const auto byte = static_cast<unsigned char>(text[i]);
    const std::size_t length = byte < 0x80 ? 1 : byte >> 5 == 6 ? 2 : byte >> 4 == 14 ? 3 : byte >> 3 == 30 ? 4 : 0;
    if (length == 0 || i + length > text.size()) {
      points.push_back('?');
      ++i;
      continue;
    }
    std::uint32_t point = length == 1 ? byte : byte & (0x7F >> length);
    for (std::size_t k = 1; k < length; ++k) point = point << 6 | (static_cast<unsigned char>(text[i + k]) & 0x3F);
    points.push_back(point);
    i += length;
  }
  return points;
}

/// A PDF string in Windows-1252, which has Latin 1 where Latin 1 has characters.
std::string pdf_string(const std::string& text) {
  static const std::pair<std::uint32_t, int> others[] = {{0x2013, 0x96}, {0x2014, 0x97}, {0x2018, 0x91}, {0x2019, 0x92},
                                                         {0x201C, 0x93}, {0x201D, 0x94}, {0x2026, 0x85}, {0x2212, '-'}};
  std::string out = "(";
  for (const std::uint32_t point : code_points(text)) {
    int byte = (point >= 0x20 && point < 0x7F) || (point >= 0xA0 && point <= 0xFF) ? static_cast<int>(point) : '?';
    for (const auto& [from, to] : others)
      if (point == from) byte = to;
    if (byte == '(' || byte == ')' || byte == '\\' || byte > 0x7E)
      out += fmt::format("\\{:03o}", static_cast<unsigned>(byte));
    else
      out += static_cast<char>(byte);
  }
  return out + ")";
}

/// Advance of a character of Helvetica, in thousandths (Adobe's font metrics; one value for those of no account).
double advance(std::uint32_t point) {
  static const int widths[] = {278,  278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333, 278, 278,
                               556,  556, 556, 556, 556, 556, 556, 556, 556, 556, 278, 278, 584, 584, 584, 556,
                               1015, 667, 667, 722, 722, 667, 611, 778, 722, 278, 500, 667, 556, 833, 722, 778,
                               667,  778, 722, 667, 611, 722, 667, 944, 667, 667, 611, 278, 278, 278, 469, 556,
                               333,  556, 556, 500, 556, 556, 278, 556, 556, 222, 222, 500, 222, 833, 556, 556,
                               556,  556, 333, 500, 278, 556, 500, 722, 500, 500, 500, 334, 260, 334, 584};
  return point >= 0x20 && point < 0x7F ? widths[point - 0x20] : 556;
}

double width_of(const Drawing::Word& word) {
  double sum = 0;
  for (const std::uint32_t point : code_points(word.text)) sum += advance(point);
  return 1e-3 * word.size * sum * (word.strong ? 1.05 : 1);
}

std::string pdf_colour(const std::string& colour) {
  if (colour.size() != 7) return "0 0 0";
  std::string text;
  for (int k = 0; k < 3; ++k) {
    const int value = std::stoi(colour.substr(1 + 2 * static_cast<std::size_t>(k), 2), nullptr, 16);
    text += (k ? " " : "") + number(value / 255.0);
  }
  return text;
}

/// A disc of four Bézier curves.
std::string pdf_disc(double x, double y, double r) {
  const double k = 0.5523 * r;
  const auto p = [](double a, double b) { return number(a) + " " + number(b) + " "; };
  return p(x + r, y) + "m " + p(x + r, y + k) + p(x + k, y + r) + p(x, y + r) + "c " + p(x - k, y + r) +
         p(x - r, y + k) + p(x - r, y) + "c " + p(x - r, y - k) + p(x - k, y - r) + p(x, y - r) + "c " +
         p(x + k, y - r) + p(x + r, y - k) + p(x + r, y) + "c f\n";
}

std::string pdf_content(const Drawing& d) {
  std::string text = "1 J\n";
  for (const auto& line : d.lines)
    text += pdf_colour(line.colour) + " RG " + number(line.width) + " w " + number(line.x1) + " " +
            number(d.height - line.y1) + " m " + number(line.x2) + " " + number(d.height - line.y2) + " l S\n";
  for (const auto& dot : d.dots)
    text += pdf_colour(dot.colour) + " rg " + pdf_disc(dot.x, d.height - dot.y, dot.radius);
  for (const auto& word : d.words) {
    const double shift = word.anchor == Drawing::Anchor::start    ? 0
                         : word.anchor == Drawing::Anchor::middle ? 0.5 * width_of(word)
                                                                  : width_of(word);
    text += std::string("0 0 0 rg BT /") + (word.strong ? "B" : "F") + " " + number(word.size) + " Tf " +
            number(word.x - shift) + " " + number(d.height - word.y) + " Td " + pdf_string(word.text) + " Tj ET\n";
  }
  return text;
}

}  // namespace

void Drawing::append(const Drawing& other) {
  for (Line line : other.lines) {
    line.y1 += height, line.y2 += height;
    lines.push_back(std::move(line));
  }
  for (Dot dot : other.dots) {
    dot.y += height;
    dots.push_back(std::move(dot));
  }
  for (Word word : other.words) {
    word.y += height;
    words.push_back(std::move(word));
  }
  width = std::max(width, other.width);
  height += other.height;
}

std::string to_svg(const Drawing& d, Svg form) {
  const auto paint = [](const char* what, const std::string& colour) {
    return std::string(" ") + what + "=\"" + (colour.empty() ? "currentColor" : colour) + "\"";
  };
  std::string text = std::string("<svg") + (form == Svg::file ? " xmlns=\"http://www.w3.org/2000/svg\"" : "") +
                     " viewBox=\"0 0 " + number(d.width) + " " + number(d.height) +
                     "\" font-family=\"Helvetica, Arial, sans-serif\">\n";
  for (const auto& line : d.lines)
    text += "<line x1=\"" + number(line.x1) + "\" y1=\"" + number(line.y1) + "\" x2=\"" + number(line.x2) + "\" y2=\"" +
            number(line.y2) + "\" stroke-width=\"" + number(line.width) + "\"" + paint("stroke", line.colour) + "/>\n";
  for (const auto& dot : d.dots)
    text += "<circle cx=\"" + number(dot.x) + "\" cy=\"" + number(dot.y) + "\" r=\"" + number(dot.radius) + "\"" +
            paint("fill", dot.colour) + "><title>" + text::xml_escaped(dot.title) + "</title></circle>\n";
  for (const auto& word : d.words)
    text += "<text x=\"" + number(word.x) + "\" y=\"" + number(word.y) + "\" style=\"font-size:" + number(word.size) +
            "px\"" +
            (word.anchor == Drawing::Anchor::start    ? ""
             : word.anchor == Drawing::Anchor::middle ? " text-anchor=\"middle\""
                                                      : " text-anchor=\"end\"") +
            (word.strong ? " font-weight=\"600\"" : "") + ">" + text::xml_escaped(word.text) + "</text>\n";
  return text + "</svg>\n";
}

std::string to_pdf(const Drawing& d) {
  const std::string content = pdf_content(d);
  const std::string font = "<< /Type /Font /Subtype /Type1 /Encoding /WinAnsiEncoding /BaseFont /Helvetica";
  const std::string objects[] = {
      "<< /Type /Catalog /Pages 2 0 R >>",
      "<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
      "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 " + number(d.width) + " " + number(d.height) +
          "] /Contents 4 0 R /Resources << /Font << /F 5 0 R /B 6 0 R >> >> >>",
      "<< /Length " + std::to_string(content.size()) + " >>\nstream\n" + content + "endstream",
      font + " >>",
      font + "-Bold >>"};
  std::string text = "%PDF-1.4\n";
  std::vector<std::size_t> offsets;
  for (const std::string& object : objects) {
    offsets.push_back(text.size());
    text += std::to_string(offsets.size()) + " 0 obj\n" + object + "\nendobj\n";
  }
  const std::size_t table = text.size();
  text += "xref\n0 " + std::to_string(offsets.size() + 1) + "\n0000000000 65535 f \n";
  for (const std::size_t offset : offsets) {
    text += fmt::format("{:010} 00000 n \n", offset);
  }
  return text + "trailer << /Size " + std::to_string(offsets.size() + 1) + " /Root 1 0 R >>\nstartxref\n" +
         std::to_string(table) + "\n%%EOF\n";
}

}  // namespace plumbline::bench
