"""Seconds and memory of a whole survey of hills with a zone and three UAVs, by phase, and of ten times its area."""

import math
import resource
import time

import numpy as np

import skyverse as sky
from skyverse.referee.photo_coverage import coverage_of
