#include "core/config_tree.h"

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <sstream>

#include "core/error.h"
#include "core/file_io.h"
#include "core/shown_text.h"

namespace ld {
namespace {

constexpr size_t kDeepest = 16;
constexpr size_t kMostKeys = 1000;  // in one map: each new one is compared with all
constexpr size_t kMostBytes = size_t{1} << 20;

/// Builds the tree from the parser's events; the events carry the line of each value.
class TreeBuilder : public YAML::EventHandler {
 public:
  explicit TreeBuilder(std::string name) : name_(std::move(name)) {}

  ConfigNode take() { return std::move(root_); }

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    // yaml-cpp reports where the next token stands; what is missing is missing behind its key.
    const bool after_key = !levels_.empty() && levels_.back().has_key;
    scalar(after_key ? levels_.back().key_mark : mark, "", anchor, "", false);
  }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override {
    fail_usage("{}: found an alias (*name); anchors and aliases are not supported, write the value out",
               at(mark));
  }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& value) override {
    // yaml-cpp marks a quoted scalar with the tag "!" and a plain one with "?".
    scalar(mark, tag == "?" || tag == "!" ? "" : tag, anchor, value, tag == "!");
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(mark, tag == "?" ? "" : tag, anchor, ConfigNode::Kind::list);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(mark, tag == "?" ? "" : tag, anchor, ConfigNode::Kind::map);
  }
  void OnMapEnd() override { close(); }

 private:
  struct Level {
    ConfigNode node;
    std::string key;  // of the entry whose value comes next
    bool has_key = false;
    YAML::Mark key_mark;
  };

  std::string at(const YAML::Mark& mark) const { return fmt::format("{}:{}", name_, mark.line + 1); }

  void check(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor) const {
    if (anchor != 0)
      fail_usage("{}: found an anchor (&name); anchors and aliases are not supported, write the value out",
                 at(mark));
    if (!tag.empty())
      fail_usage("{}: found the tag '{}'; tags are not supported, remove it", at(mark), shown(tag));
  }

  void scalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor, const std::string& value,
              bool quoted) {
    check(mark, tag, anchor);
    if (!levels_.empty() && levels_.back().node.kind == ConfigNode::Kind::map && !levels_.back().has_key) {
      Level& level = levels_.back();
      if (const ConfigNode* earlier = level.node.find(value))
        fail_usage("{}: duplicate key '{}', first given at {}; remove one of them", at(mark), shown(value),
                   earlier->origin);
      if (level.node.entries.size() >= kMostKeys)
        fail_usage("{}: more than {} keys in one map; is it the right kind of file?", at(mark), kMostKeys);
      level.key = value;
      level.has_key = true;
      level.key_mark = mark;
      return;
    }
    ConfigNode node;
    node.kind = ConfigNode::Kind::scalar;
    node.text = value;
    node.quoted = quoted;
    node.origin = at(mark);
    place(std::move(node));
  }

  void open(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor, ConfigNode::Kind kind) {
    check(mark, tag, anchor);
    if (levels_.size() >= kDeepest) fail_usage("{}: nested more than {} deep", at(mark), kDeepest);
    if (!levels_.empty() && levels_.back().node.kind == ConfigNode::Kind::map && !levels_.back().has_key)
      fail_usage("{}: a list or a map stands where a key is expected", at(mark));
    Level level;
    level.node.kind = kind;
    // yaml-cpp places a map or a list at its first entry, which may be a line below the key that it belongs
    // to.
    level.node.origin = at(!levels_.empty() && levels_.back().has_key ? levels_.back().key_mark : mark);
    levels_.push_back(std::move(level));
  }

  void close() {
    ConfigNode node = std::move(levels_.back().node);
    levels_.pop_back();
    place(std::move(node));
  }

  void place(ConfigNode node) {
    if (levels_.empty()) {
      root_ = std::move(node);
    } else if (levels_.back().node.kind == ConfigNode::Kind::list) {
      levels_.back().node.items.push_back(std::move(node));
    } else {
      levels_.back().node.entries.emplace_back(levels_.back().key, std::move(node));
      levels_.back().has_key = false;
    }
  }

  std::string name_;
  ConfigNode root_;
  std::vector<Level> levels_;
};

ConfigNode parse_value(const std::string& text, const std::string& name) {
  if (text.size() > kMostBytes)
    fail_usage("{}: {} bytes; expected at most {}; is it the right kind of file?", name, text.size(),
               kMostBytes);
  std::istringstream stream(text);
  TreeBuilder builder(name);
  try {
    YAML::Parser parser(stream);
    parser.HandleNextDocument(builder);
    TreeBuilder rest(name);
    if (parser.HandleNextDocument(rest)) fail_usage("{}: found a second document (---); expected one", name);
  } catch (const YAML::Exception& error) {
    fail_usage("{}:{}: not valid YAML: {}", name, error.mark.line + 1, shown(error.msg, 200));
  }
  return builder.take();
}

}  // namespace

const ConfigNode* ConfigNode::find(const std::string& key) const {
  for (const auto& [name, node] : entries)
    if (name == key) return &node;
  return nullptr;
}

ConfigNode parse_config(const std::string& text, const std::string& name) {
  ConfigNode root = parse_value(text, name);
  if (root.kind == ConfigNode::Kind::scalar && root.text.empty() && !root.quoted)
    root.kind = ConfigNode::Kind::map;
  if (root.kind != ConfigNode::Kind::map) fail_usage("{}: expected 'key: value' lines at the top", name);
  if (root.origin.empty()) root.origin = name;
  return root;
}

ConfigNode read_config(const std::filesystem::path& path) {
  return parse_config(read_file(path, kMostBytes), path.string());
}

void apply_override(ConfigNode& root, const std::string& assignment) {
  const size_t equals = assignment.find('=');
  if (equals == 0 || equals == std::string::npos)
    fail_usage("command line: expected key.sub=value, found '{}'", shown(assignment));
  const std::string origin = "command line";
  ConfigNode value = parse_value(assignment.substr(equals + 1), origin);
  ConfigNode* node = &root;
  std::istringstream path(assignment.substr(0, equals));
  for (std::string key; std::getline(path, key, '.');) {
    if (node->kind != ConfigNode::Kind::map) *node = ConfigNode{};
    ConfigNode* child = const_cast<ConfigNode*>(node->find(key));
    if (child == nullptr) {
      node->entries.emplace_back(key, ConfigNode{});
      child = &node->entries.back().second;
      child->origin = origin;
    }
    node = child;
  }
  *node = std::move(value);
  node->origin = origin;
  if (node->kind == ConfigNode::Kind::map && node->entries.empty()) node->kind = ConfigNode::Kind::scalar;
}

}  // namespace ld
