"""DEM runs in jobs of a cluster."""

from grainfit.campaign.cluster.executor import cluster_executor as cluster_executor
from grainfit.campaign.cluster.options import ClusterOptions as ClusterOptions
