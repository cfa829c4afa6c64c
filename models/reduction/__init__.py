"""Fewer rules with a proved error, and smaller boxes with tighter bounds.

reduced_model      ReducedModel: a model of fewer rules, its weights, and its error
tensor_reduction   reduce_rules: truncated HOSVD of the vertices over the premises' weights
rule_tensor        the vertices as a tensor, and the directions in which its rules differ
simplex_hull       weights of a simplex around points: nonnegative decimals of sum one
vertex_merging     merge_vertices: nearly equal vertices replaced by one of them
exact_residual     original minus reduced vertices, in integers
error_bound        ErrorBound: how large that is, and as norm-bounded uncertainty
norm_block         one block D Delta [E, F] around given matrices, checked exactly
cell_models        CellModels: one model for each cell of a plant's box
box_refinement     refine: a plant's box cut into cells where that reduces the width (hull_spread)
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.models.reduction.box_refinement import refine as refine
    from takagi.models.reduction.cell_models import CellModels as CellModels
    from takagi.models.reduction.cell_models import ModelCell as ModelCell
    from takagi.models.reduction.error_bound import ErrorBound as ErrorBound
    from takagi.models.reduction.norm_block import NormBlock as NormBlock
    from takagi.models.reduction.reduced_model import MergedModel as MergedModel
    from takagi.models.reduction.reduced_model import ReducedModel as ReducedModel
    from takagi.models.reduction.rule_tensor import mode_spectrum as mode_spectrum
    from takagi.models.reduction.tensor_reduction import reduce_rules as reduce_rules
    from takagi.models.reduction.vertex_merging import merge_vertices as merge_vertices

__getattr__, __dir__ = lazy_names(__name__)
