#include "series_files.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "survey/words/network_words.hpp"

namespace plumbline::survey {

namespace {

void json_number(double value, std::string& out) {
  if (!std::isfinite(value)) {
    out += "null";
    return;
  }
  char text[32];
  out.append(text, std::to_chars(text, text + sizeof text, value).ptr);
}

void json_vector(const Eigen::Vector3d& v, std::string& out) {
  for (int k = 0; k < 3; ++k) out += k ? ", " : "[", json_number(v[k], out);
  out += ']';
}

void json_text(const std::string& text, std::string& out) {
  out += '"';
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  out += '"';
}

void json_list(const std::vector<std::string>& ids, std::string& out) {
  out += '[';
  for (size_t i = 0; i < ids.size(); ++i) {
    if (i) out += ", ";
    json_text(ids[i], out);
  }
  out += ']';
}

const char* level_word(Level l) {
  return l == Level::reached ? "reached" : l == Level::may_be_reached ? "may be reached" : "below";
}

void json_field(const char* name, std::string& out, bool first = false) {
  out += first ? "\"" : ", \"";
  out += name;
  out += "\": ";
}

}  // namespace

std::string series_as_json(const EpochSeries& s, const SeriesText& text) {
  std::string out = "{";
  json_field("unit_of_time", out, true), json_text(text.unit, out);
  json_field("epochs", out), out += "[";
  for (size_t k = 0; k < text.labels.size(); ++k) {
    out += k ? ", {" : "{";
    json_field("name", out, true), json_text(text.labels[k], out);
    json_field("time", out), json_number(text.times[k], out);
    json_field("variance_factor", out), json_number(s.factors[k], out);
    out += "}";
  }
  out += "]";
  json_field("variances", out), json_text(s.variances, out);
  json_field("sigma0", out), json_number(s.sigma0, out);
  json_field("bartlett", out), json_number(s.bartlett, out);
  json_field("bartlett_critical", out), json_number(s.bartlett_critical, out);
  json_field("degrees_of_freedom", out), out += std::to_string(s.degrees_of_freedom);
  json_field("warning_level", out), json_number(text.options.warning_level, out);
  json_field("alarm_level", out), json_number(text.options.alarm_level, out);
  json_field("stable", out), json_list(s.stable, out);
  json_field("contradicted", out), json_list(s.contradicted, out);
  json_field("seen_once", out), json_list(s.seen_once, out);
  json_field("not_followed", out), json_list(s.not_followed, out);
  json_field("not_compared", out), json_list(s.not_compared, out);
  json_field("notes", out), json_list(text.notes, out);
  json_field("points", out), out += "[";
  for (size_t i = 0; i < s.points.size(); ++i) {
    const SeriesPoint& p = s.points[i];
    out += i ? ",\n{" : "\n{";
    json_field("id", out, true), json_text(p.id, out);
    json_field("stable", out), out += p.stable ? "true" : "false";
    json_field("first_epoch", out), out += std::to_string(p.first);
    json_field("reference_epochs", out);  // of E, N, H
    out += "[" + std::to_string(p.reference[0]) + ", " + std::to_string(p.reference[1]) + ", " +
           std::to_string(p.reference[2]) + "]";
    json_field("velocity", out), json_vector(p.velocity, out);
    json_field("velocity_sigma", out), json_vector(p.velocity_sigma, out);
    json_field("velocity_statistic", out), json_number(p.velocity_statistic, out);
    json_field("velocity_critical", out), json_number(p.velocity_critical, out);
    json_field("moves", out), out += p.moves ? "true" : "false";
    json_field("misfit", out), json_number(p.misfit, out);
    json_field("misfit_critical", out), json_number(p.misfit_critical, out);
    json_field("movements", out), out += "[";
    for (size_t k = 0; k < p.at.size(); ++k) {
      const SeriesPoint::At& at = p.at[k];
      out += k ? ", {" : "{";
      json_field("epoch", out, true), out += std::to_string(at.epoch);
      json_field("movement", out), json_vector(at.movement, out);
      json_field("sigma", out), json_vector(at.sigma, out);
      json_field("statistic", out), json_number(at.statistic, out);
      json_field("critical", out), json_number(at.critical, out);
      json_field("moved", out), out += at.moved ? "true" : "false";
      json_field("warning", out), json_text(level_word(at.warning), out);
      json_field("alarm", out), json_text(level_word(at.alarm), out);
      out += "}";
    }
    out += "]}";
  }
  return out + "]}\n";
}

std::string series_as_csv(const EpochSeries& s, const SeriesText& text) {
  std::string out = "point,epoch,time [" + text.unit +
                    "],dE [mm],dN [mm],dH [mm],sE [mm],sN [mm],sH [mm],E since,N since,H "
                    "since,statistic,critical,moved,warning,alarm\n";
  const auto cell = [&](double value, int digits) {
    out += ",";
    if (std::isfinite(value)) out += fixed_digits(value, digits);
  };
  const auto name = [&](const std::string& id) {
    if (id.find_first_of(",\"\n") == std::string::npos) return void(out += id);
    out += '"';
    for (const char c : id) out += c == '"' ? std::string("\"\"") : std::string(1, c);
    out += '"';
  };
  for (const SeriesPoint& p : s.points)
    for (const SeriesPoint::At& at : p.at) {
      name(p.id), out += ",", name(text.labels[at.epoch]);
      cell(text.times[at.epoch], 3);
      for (int k = 0; k < 3; ++k) cell(1000 * at.movement[k], 3);
      for (int k = 0; k < 3; ++k) cell(1000 * at.sigma[k], 3);
      for (size_t k = 0; k < 3; ++k) {  // the epoch that measured the coordinate first
        out += ",";
        if (std::isfinite(at.movement[static_cast<Eigen::Index>(k)])) name(text.labels[p.reference[k]]);
      }
      cell(at.statistic, 2), cell(at.critical, 2);
      out += at.moved ? ",yes," : ",no,";
      out += level_word(at.warning);
      out += ",";
      out += level_word(at.alarm);
      out += "\n";
    }
  return out;
}

}  // namespace plumbline::survey
