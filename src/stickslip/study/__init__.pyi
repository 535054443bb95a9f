from .reading import Job as Job
from .reading import job as job
from .reading import read as read
