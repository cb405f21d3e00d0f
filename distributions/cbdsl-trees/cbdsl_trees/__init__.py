"""Programs as behaviours of py_trees and as trees of BehaviorTree.CPP."""
