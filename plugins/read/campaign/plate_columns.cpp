// Words for the columns of a plate table, in the languages that tables come in. Here, because only campaigns have them.
#include "campaign_folder.hpp"

namespace plumbline::campaign {

const std::map<std::string, std::string>& plate_column_names() {
  static const std::map<std::string, std::string> names = [] {
    std::map<std::string, std::string> all = {{"anker", "anchor"},
                                              {"ankername", "anchor"},
                                              {"rolle", "role"},
                                              {"geschoss", "floor"},
                                              {"stockwerk", "floor"},
                                              {"etage", "floor"},
                                              {"spalte", "column"},
                                              {"zeile", "row"},
                                              {"reihe", "row"},
                                              {"tag_familie", "tag_family"},
                                              {"familie", "tag_family"},
                                              {"tag_nr", "tag_id"},
                                              {"tag_nummer", "tag_id"},
                                              {"tag_gr\u00F6\u00DFe", "tag_size"},
                                              {"tag_groesse", "tag_size"},
                                              {"azimut", "facing_azimuth"},
                                              {"blickrichtung", "facing_azimuth"},
                                              {"charge", "batch"}};
    for (const char* own : {"anchor", "role", "floor", "column", "row", "tag_family", "tag_id", "tag_size", "tag_x",
                            "tag_y", "tag_z", "facing_azimuth", "mounting_x", "mounting_y", "mounting_z", "batch"})
      all[own] = own;
    return all;
  }();
  return names;
}

}  // namespace plumbline::campaign
