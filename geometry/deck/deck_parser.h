// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Blocks of a deck to AbaqusDeck. Internal to geometry/deck.
//
// Parts are kept with their own labels until an instance places them; what lies outside of parts is one more part, without a name, that is placed where
// it stands. References ("12", "set", "instance.12", "instance.set") are resolved when the line is read, as Abaqus does, except element nodes: these
// may be defined later in the same part.

#include <Eigen/Geometry>
#include <set>
#include <unordered_map>

#include "geometry/deck/abaqus_deck.h"

namespace mv {

class DeckParser {
 public:
  explicit DeckParser(AbaqusDeck& deck) : deck_(deck) {}
  void run();

 private:
  struct RawElement {
    long label;
    std::string type;
    std::vector<long> nodes;
    DeckPlace place;
  };
  struct RawSet {
    std::vector<long> labels;
    std::vector<std::string> names;
    DeckPlace place;
    std::string from_element_set;  // node sets only
  };
  struct Part {
    std::string name;
    std::vector<std::pair<long, Vec3>> nodes;
    std::unordered_map<long, std::size_t> node_at;
    std::vector<RawElement> elements;
    std::unordered_map<long, std::size_t> element_at;
    std::map<std::string, RawSet> node_sets, element_sets;
    std::vector<DeckSection> sections;
  };
  struct Labels {
    std::unordered_map<long, int> nodes, elements;  // label to index
  };
  struct Distribution {
    std::vector<double> otherwise;
    std::map<long, std::vector<double>> elements;
    std::map<std::string, std::vector<double>> sets;
    DeckPlace place;
  };

  using Block = DeckBlock;
  void read(const Block& block);
  bool read_model(const Block& block);
  bool read_material(const Block& block);
  bool read_history(const Block& block);

  void read_nodes(const Block& block);
  void read_elements(const Block& block);
  void read_set(const Block& block, bool is_node_set);
  void read_surface(const Block& block);
  void read_section(const Block& block);
  void read_distribution(const Block& block);
  void read_orientation(const Block& block);
  void read_amplitude(const Block& block);
  void read_instance(const Block& block);
  void read_boundary(const Block& block);
  void read_load(const Block& block, bool is_surface_load);
  void read_step_control(const Block& block);

  void place_part(const Part& part, const std::string& instance, const Eigen::Isometry3d& frame);
  void place_root();
  std::vector<int> resolve(const std::string& token, const DeckPlace& place, bool is_node) const;
  std::vector<int> members(const RawSet& set, const Labels& labels, const std::string& prefix, bool is_node) const;
  void finish();

  std::vector<double> row(const Block& block) const;  // all numbers of the data lines
  std::vector<double> numbers(const Block::Data& data, std::size_t first = 0) const;
  [[noreturn]] void fail(const DeckPlace& place, const std::string& what) const { deck_.lines.fail(place, what); }
  /// The option's value; fails when it is missing.
  std::string need(const Block& block, const std::string& option) const;

  AbaqusDeck& deck_;
  Part root_;
  std::map<std::string, Part> parts_;
  Part* part_ = &root_;
  bool root_is_placed_ = false;
  std::map<std::string, Labels> labels_;  // by instance, "" for the root
  std::map<std::string, Distribution> distributions_;
  DeckMaterial* material_ = nullptr;
  int step_ = -1;
  int cleared_in_step_ = -2;  // step whose op=NEW has dropped the earlier boundary conditions
  std::map<std::string, int> ignored_;
};

}  // namespace mv
